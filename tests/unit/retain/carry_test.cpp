// Values of one program in another one: what fits, and what is said of the rest.
#include "retain/carry.h"

#include <algorithm>

#include "retain/gather.h"
#include "tests/unit/retain/plant.h"

namespace plc::test {
namespace {

using retain::Start;
using Lines = std::vector<std::string>;

/// The present program after a start with what the old one has at its start.
struct Restart {
  std::unique_ptr<runtime::Resource> resource;
  retain::Carried carried;

  Restart(const std::string& was, const std::string& is, Start start = Start::kWarm) {
    const auto old = load_text(was);
    resource = load_text(is);
    if (old == nullptr || resource == nullptr) return;
    const retain::Kept from = retain::find_kept(*old), to = retain::find_kept(*resource);
    std::vector<std::byte> stored(from.layout.bytes), values(to.layout.bytes);
    retain::Gatherer(*old, from).copy_initial(stored);
    retain::Gatherer gatherer(*resource, to);
    gatherer.copy_initial(values);
    carried = carry_over(from.layout, stored, to.layout, values, start);
    gatherer.restore(values);
  }
  [[nodiscard]] std::string value(std::string_view path) const { return value_of(*resource, path); }
};

/// A program with these declarations.
std::string program(const std::string& variables, const std::string& types = {}) {
  return with_task(types + "PROGRAM Main\n" + variables + "\n;\nEND_PROGRAM\n");
}
std::string retained(const std::string& variables) { return program("VAR RETAIN " + variables + " END_VAR"); }

TEST(CarryOver, KeepsWhatIsTheSame) {
  const Restart r(retained("a : INT := 7; s : STRING[5] := 'abc'; l : LREAL := 1.5; b : BOOL := TRUE;"),
                  retained("b : BOOL; a : INT; s : STRING[5]; fresh : INT := 4; l : LREAL;"));
  EXPECT_EQ(r.value("main.a"), "7");
  EXPECT_EQ(r.value("main.s"), "'abc'");
  EXPECT_EQ(r.value("main.l"), "1.5");
  EXPECT_EQ(r.value("main.b"), "1");
  EXPECT_EQ(r.value("main.fresh"), "4");
  EXPECT_EQ(r.carried.kept, 4u);
  EXPECT_EQ(r.carried.misfits, Lines{});
}

/// One variable x from type to type.
struct Change {
  std::string was, is, value, misfit;
};
void PrintTo(const Change& change, std::ostream* out) { *out << change.was << " -> " << change.is; }

class CarryOverTypes : public testing::TestWithParam<Change> {};

TEST_P(CarryOverTypes, KeepsTheValueThatFits) {
  const Change& c = GetParam();
  const std::string types =
      "TYPE Old : (Off, Filling, Full); New : (Empty, Full, Filling); Few : (Off, Low); Level : INT (0..100) := 1;\n"
      "Was : STRUCT a : INT := 3; gone : INT; n : REAL := 2.5; END_STRUCT;\n"
      "Is : STRUCT n : LREAL; a : INT; more : INT := 8; END_STRUCT; END_TYPE\n";
  const Restart r(program("VAR RETAIN x : " + c.was + "; END_VAR", types),
                  program("VAR RETAIN x : " + c.is + "; END_VAR", types));
  EXPECT_EQ(r.value("main.x"), c.value);
  EXPECT_EQ(r.carried.misfits, c.misfit.empty() ? Lines{} : Lines{c.misfit});
}

INSTANTIATE_TEST_SUITE_P(
    Changes, CarryOverTypes,
    testing::Values(
        Change{"INT := -5", "DINT", "-5", ""},
        Change{"DINT := 70000", "INT", "0", "main.x: 70000 is not a value of INT"},
        Change{"INT := -1", "UINT", "0", "main.x: -1 is not a value of UINT"},
        Change{"LWORD := 16#FFFF_FFFF_FFFF_FFFF", "ULINT", "18446744073709551615", ""},
        Change{"BOOL := TRUE", "INT", "1", ""}, Change{"INT := 2", "BOOL", "0", "main.x: 2 is not a value of BOOL"},
        Change{"INT := 50", "REAL", "50", ""},
        Change{"DINT := 16777217", "REAL", "0", "main.x: 16777217 is not a value of REAL"},
        Change{"REAL := 0.5", "LREAL", "0.5", ""},
        Change{"LREAL := 1E300", "REAL", "0", "main.x: 1e+300 is not a value of REAL"},
        Change{"REAL := 0.5", "INT", "0", "main.x: was REAL and is INT"},
        Change{"TIME := T#5s", "LTIME", "5000000000", ""},
        Change{"TIME := T#5s", "INT", "0", "main.x: was TIME and is INT"}, Change{"INT := 40", "Level", "40", ""},
        Change{"INT := 400", "Level", "1", "main.x: 400 is not a value of Level"},
        Change{"Old := Filling", "New", "2", ""},
        Change{"Old := Full", "Few", "0", "main.x: Full is not a value of Few"},
        Change{"STRING[9] := 'abc'", "STRING[3]", "'abc'", ""},
        Change{"STRING[9] := 'abcd'", "STRING[3]", "''", "main.x: its 4 characters do not fit into STRING[3]"},
        Change{"WSTRING[4] := \"ab\"", "WSTRING[8]", "\"ab\"", ""},
        Change{"STRING := 'a'", "WSTRING", "\"\"", "main.x: was STRING[80] and is WSTRING[80]"},
        Change{"ARRAY [1..3] OF INT := [1, 2, 3]", "ARRAY [0..2] OF INT", "[0, 1, 2]",
               "main.x: 1 of its 3 elements are outside of ARRAY [0..2] OF INT"},
        Change{"ARRAY [1..2] OF DINT := [70000, 5]", "ARRAY [1..3] OF INT", "[0, 5, 0]",
               "main.x[1]: 70000 is not a value of INT"},
        Change{"ARRAY [1..3] OF DINT := [3(70000)]", "ARRAY [1..3] OF INT", "[0, 0, 0]",
               "main.x[1] (and 2 more): 70000 is not a value of INT"},
        Change{"ARRAY [1..2] OF INT := [1, 2]", "INT", "0", "main.x: was ARRAY [1..2] OF INT and is INT"},
        Change{"Was", "Is", "(n := 2.5, a := 3, more := 8)", "main.x.gone: is not there any more"}));

TEST(CarryOver, SaysWhatIsGone) {
  const Restart r(retained("a, b : INT := 7;"), program("VAR RETAIN a : INT; END_VAR VAR b : INT; END_VAR"));
  EXPECT_EQ(r.value("main.b"), "0");
  EXPECT_EQ(r.carried.misfits, Lines{"main.b: is not there any more, or not retained"});
}

TEST(CarryOver, ColdKeepsPersistentAlone) {
  const std::string text =
      "VAR RETAIN r : INT := %; END_VAR VAR PERSISTENT p : INT := %; END_VAR\n"
      "VAR RETAIN PERSISTENT b : INT := %; END_VAR";
  const auto with = [&](char value) {
    std::string out = text;
    std::replace(out.begin(), out.end(), '%', value);
    return program(out);
  };
  const auto values = [&](Start start) {
    const Restart r(with('7'), with('1'), start);
    return r.value("main.r") + r.value("main.p") + r.value("main.b");
  };
  EXPECT_EQ(values(Start::kWarm), "777");
  EXPECT_EQ(values(Start::kCold), "177");
  EXPECT_EQ(values(Start::kOrigin), "111");
}

TEST(CarryOver, NonRetainBeginsAnewInAnInstanceThatIsKept) {
  const auto text = [](const std::string& value) {
    return program("VAR RETAIN f : Fb; END_VAR VAR PERSISTENT g : Fb; END_VAR",
                   "FUNCTION_BLOCK Fb VAR a : INT := " + value + "; END_VAR VAR NON_RETAIN n : INT := " + value +
                       "; END_VAR\nVAR RETAIN r : INT := " + value + "; END_VAR a := n; END_FUNCTION_BLOCK\n");
  };
  const Restart warm(text("7"), text("1"));
  EXPECT_EQ(warm.value("main.f.a") + warm.value("main.f.n") + warm.value("main.f.r"), "717");
  const Restart cold(text("7"), text("1"), Start::kCold);
  EXPECT_EQ(cold.value("main.f.a") + cold.value("main.f.r") + cold.value("main.g.a") + cold.value("main.g.r"), "1177");
}

TEST(CarryOver, FollowsARetainedPartThatBecomesAWholeAndBack) {
  const auto text = [](const std::string& instance, const std::string& part, int value) {
    return program(instance + " f : ARRAY [1..2] OF Fb; END_VAR", "FUNCTION_BLOCK Fb " + part +
                                                                      " n : INT := " + std::to_string(value) +
                                                                      "; END_VAR n := n + 1; END_FUNCTION_BLOCK\n");
  };
  const std::string part = text("VAR", "VAR RETAIN", 7), whole = text("VAR RETAIN", "VAR", 7);
  const Restart up(part, text("VAR RETAIN", "VAR", 1)), down(whole, text("VAR", "VAR RETAIN", 1));
  EXPECT_EQ(up.value("main.f[1].n") + up.value("main.f[2].n"), "77");
  EXPECT_EQ(down.value("main.f[1].n") + down.value("main.f[2].n"), "77");
  EXPECT_EQ(up.carried.misfits, Lines{});
  EXPECT_EQ(down.carried.misfits, Lines{});
}

TEST(CarryOver, GlobalsOfTasksAndOfNobody) {
  const auto text = [](const std::string& value) {
    return with_task("VAR_GLOBAL RETAIN Own, Hmi : INT := " + value +
                     "; END_VAR\nVAR_GLOBAL PERSISTENT List : ARRAY [1..3] OF INT := [3(" + value +
                     ")]; END_VAR\nPROGRAM Main VAR_EXTERNAL Own, Hmi : INT; List : ARRAY [1..3] OF INT; END_VAR\n"
                     "  Own := Own + Hmi; List[2] := Own; END_PROGRAM\n");
  };
  const Restart r(text("7"), text("1"));
  EXPECT_EQ(r.value("Own"), "7");
  EXPECT_EQ(r.value("Hmi"), "7");
  EXPECT_EQ(r.value("List"), "[7, 7, 7]");
  // The task sees them too, in its first scan.
  EXPECT_FALSE(r.resource->program(0).execute({1}));
  EXPECT_EQ(r.value("Own"), "14");
  EXPECT_EQ(r.value("List"), "[7, 14, 7]");
}

}  // namespace
}  // namespace plc::test
