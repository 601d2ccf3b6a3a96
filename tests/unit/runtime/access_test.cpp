#include "runtime/access.h"

#include <array>

#include "tests/unit/runtime/run_support.h"

namespace plc::test {
namespace {

using core::Code;
using runtime::Access;

struct Plant : OneProgram {
  Plant() {
    b.global("Level", b.type(TypeId::kInt), {}, {.list = "Tank", .address = "%IW3"});
    b.global("Level", b.type(TypeId::kInt), {}, {.list = "Boiler"});
    b.global("Only", b.type(TypeId::kReal), {}, {.list = "Tank"});
    b.global("Fixed", b.type(TypeId::kInt), bytes_of<std::int16_t>(9), {.constant = true});
    const std::uint32_t row = b.array(b.type(TypeId::kInt), 3, -1);
    main.variable("grid", b.array(row, 2, 1));
    main.variable("name", b.string(5));
    main.variable("wide", b.string(4, TypeId::kWstring));
    main.variable("delay", b.type(TypeId::kTime));
    main.variable("percent", b.limited(TypeId::kUsint, 0, 100, "Percent"));
    main.variable("big", b.type(TypeId::kUlint));
    main.variable("r", b.type(TypeId::kLreal));
    main.variable("c", b.type(TypeId::kChar));
    main.variable("flag", b.boolean());
    main.variable("hidden#1", b.boolean());
  }
  /// Result of a write: "" or the code's name. The tasks run once, so that a variable they export has changed.
  static std::string put(runtime::Resource& r, std::string_view path, std::string_view text) {
    Access access(r);
    const auto place = access.find_leaf(path);
    if (!place) return std::string(core::info(place.error().code).name);
    const auto problem = access.write(*place, text);
    for (std::size_t task = 0; task < r.task_count(); ++task) r.program(task).execute({0});
    return problem ? std::string(core::info(problem->code).name) : std::string{};
  }
};

TEST(Access, PathsInAnyLetterCase) {
  Plant p;
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  EXPECT_EQ(Plant::put(*r, "tank.LEVEL", "5"), "");
  EXPECT_EQ(Plant::put(*r, "Boiler.Level", "6"), "");
  EXPECT_EQ(value_of(*r, "%iw3"), "5");
  EXPECT_EQ(Plant::put(*r, "only", "1.5"), "");
  EXPECT_EQ(value_of(*r, "Tank.Only"), "1.5");
  EXPECT_EQ(Plant::put(*r, "main0.GRID[2,1]", "-7"), "");
  EXPECT_EQ(value_of(*r, "Main0.grid[2][1]"), "-7");
  EXPECT_EQ(value_of(*r, "Cyclic.Main0.grid"), "[[0, 0, 0], [0, 0, -7]]");
}

TEST(Access, WrongPathsSayWhatIsNear) {
  Plant p;
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  const Access access(*r);
  const auto typo = access.find("Main0.delai");
  ASSERT_FALSE(typo);
  EXPECT_EQ(typo.error().code, Code::P7101);
  EXPECT_NE(typo.error().help.find("delay"), std::string::npos);
  EXPECT_FALSE(access.find("Level"));  // in two lists
  for (const char* path : {"", ".", "Main0.", "Main0.grid[3,0]", "Main0.grid[1,2]", "Main0.grid[1", "Main0.flag[0]",
                           "[1]", "Main0.grid[]", "Main0.grid[99999999999999999999]", "%QX0.0", "nothing"}) {
    EXPECT_FALSE(access.find(path)) << path;
  }
  EXPECT_EQ(access.find_leaf("Main0.grid").error().code, Code::P7102);
}

TEST(Access, ListMatchesGlobs) {
  Plant p;
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  const Access access(*r);
  EXPECT_EQ(access.list("*level"), (std::vector<std::string>{"Tank.Level", "Boiler.Level"}));
  EXPECT_EQ(access.list("main0.grid[?]*").size(), 6u);
  EXPECT_EQ(access.list("Main0.*", 2).size(), 2u);
  EXPECT_TRUE(access.list("Main0.hidden").empty());
  EXPECT_EQ(access.list("*#*"), (std::vector<std::string>{"Main0.hidden#1"}));
  for (const std::string& path : access.list()) EXPECT_TRUE(access.find_leaf(path)) << path;
}

/// Two instances of a program with located, external and own variables, one of them inside a function block.
struct Aliases : testing::Test {
  ImageBuilder b;
  std::unique_ptr<runtime::Resource> r;

  Aliases() {
    b.global("Level", b.type(TypeId::kInt));                                                 // 0: declared
    b.global("Logic.Lamp", b.boolean(), {}, {.address = "%QX0.0"});                          // 1: located in Logic
    b.global("%QW4", b.array(b.type(TypeId::kInt), 2, 1), {}, {.address = "%QW4"});          // 2: located twice
    b.global("Unused.Spare", b.boolean(), {}, {.input = true, .address = "%IX7.0"});         // 3: no instance has it
    b.global("Fixed", b.type(TypeId::kInt), bytes_of<std::int16_t>(9), {.constant = true});  // 4
    PouBuilder fb = b.pou("Fb", PouKind::kFunctionBlock);
    fb.variable("own", b.boolean());
    fb.alias("row", 2);
    fb.alias("Level", 0);
    const std::uint32_t fb_pou = fb.finish();
    PouBuilder logic = b.pou("Logic", PouKind::kProgram);
    logic.variable("own", b.boolean());
    logic.instance_of("fb", fb_pou);
    logic.alias("Lamp", 1);
    logic.alias("table", 2);
    logic.alias("lvl", 0);
    logic.alias("Fixed", 4);
    logic.alias("edge#1", 1);
    const std::uint32_t pou = logic.finish();
    b.task("T", 10'000'000, {pou, pou});
    r = load(b);
  }
};

TEST_F(Aliases, AreTheGlobalsTheyName) {
  ASSERT_NE(r, nullptr);
  EXPECT_EQ(Plant::put(*r, "logic0.LAMP", "1"), "");
  for (const char* path : {"Logic1.Lamp", "Logic.Lamp", "%qx0.0", "T.Logic1.Lamp"}) EXPECT_EQ(value_of(*r, path), "1");
  EXPECT_EQ(Plant::put(*r, "Logic1.fb.row[2]", "-3"), "");
  for (const char* path : {"Logic0.table", "%QW4"}) EXPECT_EQ(value_of(*r, path), "[0, -3]") << path;
  EXPECT_EQ(value_of(*r, "%QW4[2]"), "-3");
  EXPECT_EQ(Plant::put(*r, "Level", "5"), "");
  EXPECT_EQ(value_of(*r, "Logic1.lvl"), "5");
  EXPECT_EQ(value_of(*r, "Logic0.fb.level"), "5");
  EXPECT_EQ(Plant::put(*r, "Logic0.Fixed", "1"), "P7106");
  const auto place = Access(*r).find("Logic0.lvl");
  ASSERT_TRUE(place);
  EXPECT_EQ(place->task, runtime::Place::kGlobal);
}

TEST_F(Aliases, ValuesCrossACycle) {
  ASSERT_NE(r, nullptr);
  EXPECT_EQ(Plant::put(*r, "Logic0.lvl", "7"), "");
  EXPECT_FALSE(r->program(0).execute({0}));
  EXPECT_EQ(value_of(*r, "Logic0.lvl"), "7");
}

TEST_F(Aliases, EverythingIsListedOnce) {
  ASSERT_NE(r, nullptr);
  const Access access(*r);
  const std::vector<std::string> expected = {"Logic0.own",  "Logic0.fb.own", "Logic0.fb.row[1]", "Logic0.fb.row[2]",
                                             "Logic0.Lamp", "Logic1.own",    "Logic1.fb.own",    "Level",
                                             "Fixed",       "Unused.Spare"};
  EXPECT_EQ(access.list(), expected);
  EXPECT_EQ(access.list("**"), expected);
  for (const std::string& path : access.list()) EXPECT_TRUE(access.find_leaf(path)) << path;
}

TEST_F(Aliases, PatternsListEveryPathThatMatches) {
  ASSERT_NE(r, nullptr);
  const Access access(*r);
  EXPECT_EQ(access.list("*lamp"), (std::vector<std::string>{"Logic0.Lamp", "Logic1.Lamp", "Logic.Lamp"}));
  EXPECT_EQ(access.list("*l"),
            (std::vector<std::string>{"Logic0.fb.Level", "Logic0.lvl", "Logic1.fb.Level", "Logic1.lvl", "Level"}));
  EXPECT_EQ(access.list("%*"), (std::vector<std::string>{"%QX0.0", "%QW4[1]", "%QW4[2]", "%IX7.0"}));
  EXPECT_EQ(access.list("%qx0.0"), (std::vector<std::string>{"%QX0.0"}));
  EXPECT_EQ(access.list("Logic1.*edge#*"), (std::vector<std::string>{"Logic1.edge#1"}));
  for (const char* pattern : {"*e*", "*o*", "*#*"}) {
    for (const std::string& path : access.list(pattern)) EXPECT_TRUE(access.find_leaf(path)) << path;
  }
}

TEST_F(Aliases, NamesListEachNameOnce) {
  ASSERT_NE(r, nullptr);
  const Access access(*r);
  const std::vector<std::string> all = {
      "Logic0.own",      "Logic0.fb.own",   "Logic0.fb.row[1]", "Logic0.fb.row[2]", "Logic0.Lamp",
      "Logic0.table[1]", "Logic0.table[2]", "Logic0.lvl",       "Logic1.own",       "Logic1.fb.own",
      "Level",           "Fixed",           "Unused.Spare"};
  EXPECT_EQ(access.list_names(), all);
  EXPECT_EQ(access.list_names("*lamp"), (std::vector<std::string>{"Logic0.Lamp"}));
  EXPECT_EQ(access.list_names("Logic1.la*"), (std::vector<std::string>{"Logic1.Lamp"}));
  EXPECT_EQ(access.list_names("Logic.*"), (std::vector<std::string>{"Logic.Lamp"}));
  EXPECT_EQ(access.list_names("*l"), (std::vector<std::string>{"Logic0.lvl", "Level"}));
  EXPECT_EQ(access.list_names("%*"), (std::vector<std::string>{"%QX0.0", "%QW4[1]", "%QW4[2]", "%IX7.0"}));
  EXPECT_EQ(access.list_names("*", 2).size(), 2u);
  for (const char* pattern : {"*", "*e*", "*o*", "%*"}) {
    for (const std::string& path : access.list_names(pattern)) EXPECT_TRUE(access.find_leaf(path)) << path;
  }
}

void expect_listed_where_found(runtime::Resource& r, std::string_view pattern) {
  const Access access(r);
  const auto listed = access.list_places(pattern);
  EXPECT_FALSE(listed.empty()) << pattern;
  for (const auto& [path, place] : listed) {
    const auto found = access.find_leaf(path);
    ASSERT_TRUE(found) << path;
    EXPECT_EQ(place.task, found->task) << path;
    EXPECT_EQ(place.offset, found->offset) << path;
    EXPECT_EQ(place.type, found->type) << path;
    EXPECT_EQ(place.constant, found->constant) << path;
  }
}

TEST_F(Aliases, AreListedWhereTheyAreFound) {
  ASSERT_NE(r, nullptr);
  for (const char* pattern : {"*", "%*", "*#*", "logic?.*", "*[2]"}) expect_listed_where_found(*r, pattern);
  Plant p;
  const auto plant = p.load();
  ASSERT_NE(plant, nullptr);
  for (const char* pattern : {"*", "%*", "*grid*", "*Level"}) expect_listed_where_found(*plant, pattern);
}

TEST_F(Aliases, WrongNamesAreNearAliases) {
  ASSERT_NE(r, nullptr);
  const auto typo = Access(*r).find("Logic0.Lmap");
  ASSERT_FALSE(typo);
  EXPECT_NE(typo.error().help.find("Lamp"), std::string::npos);
  EXPECT_FALSE(Access(*r).find("Logic0.Lamp.x"));
  EXPECT_FALSE(Access(*r).find("Logic.Lamps"));
  EXPECT_FALSE(Access(*r).find("%QW4[3]"));
}

TEST(Access, ABlockWhoseAliasIsItselfIsListedToAnEnd) {
  ImageBuilder b;
  PouBuilder fb = b.pou("Fb", PouKind::kFunctionBlock);
  fb.variable("x", b.boolean());
  fb.alias("me", 0);
  const std::uint32_t pou = fb.finish();
  b.global("One", b.image.pous[pou].instance_type);
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  main.alias("one", 0);
  b.task("T", 10'000'000, {main.finish()});
  auto r = load(b);
  ASSERT_NE(r, nullptr);
  const Access access(*r);
  EXPECT_EQ(access.list(), (std::vector<std::string>{"One.x"}));
  EXPECT_EQ(access.list("*x"), (std::vector<std::string>{"Main0.one.x", "One.x", "One.me.x"}));
  EXPECT_TRUE(access.find_leaf("Main0.one.me.me.x"));
  EXPECT_EQ(access.list_names(), (std::vector<std::string>{"One.x", "One.me.x"}));
}

TEST(Access, AGlobalCalledLikeAnInstanceIsFoundAsAValue) {
  OneProgram p;
  p.b.global("Main0", p.b.type(TypeId::kInt));
  p.main.variable("x", p.b.boolean());
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  const Access access(*r);
  EXPECT_EQ(access.list(), (std::vector<std::string>{"Main0.x", "Main0"}));
  const auto place = access.find_leaf("Main0");
  ASSERT_TRUE(place);
  EXPECT_EQ(place->task, runtime::Place::kGlobal);
  EXPECT_EQ(access.find("Main0")->task, 0u);
}

TEST(Access, WritingNormalises) {
  Plant p;
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  EXPECT_EQ(Plant::put(*r, "Main0.flag", "2"), "P7103");
  EXPECT_EQ(Plant::put(*r, "Main0.flag", "true"), "");
  EXPECT_EQ(Plant::put(*r, "Main0.percent", "101"), "P7104");
  EXPECT_EQ(Plant::put(*r, "Main0.percent", "-1"), "P7104");
  EXPECT_EQ(Plant::put(*r, "Main0.percent", "16#64"), "");
  EXPECT_EQ(value_of(*r, "Main0.percent"), "100");
  EXPECT_EQ(Plant::put(*r, "Tank.Level", "32768"), "P7104");
  EXPECT_EQ(Plant::put(*r, "Tank.Level", "-32_768"), "");
  EXPECT_EQ(Plant::put(*r, "Tank.Level", "12a"), "P7103");
  EXPECT_EQ(Plant::put(*r, "Tank.Level", ""), "P7103");
  EXPECT_EQ(Plant::put(*r, "Main0.big", "18446744073709551615"), "");
  EXPECT_EQ(value_of(*r, "Main0.big"), "18446744073709551615");
  EXPECT_EQ(Plant::put(*r, "Main0.big", "18446744073709551616"), "P7104");
  EXPECT_EQ(Plant::put(*r, "Main0.name", "'toolong'"), "P7105");
  EXPECT_EQ(Plant::put(*r, "Fixed", "1"), "P7106");
  EXPECT_EQ(value_of(*r, "Fixed"), "9");
}

TEST(Access, TextOfValuesReadsBack) {
  Plant p;
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  const std::pair<const char*, const char*> cases[] = {
      {"Main0.name", "'a$'$N$$'"}, {"Main0.name", "'$80$00'"}, {"Main0.wide", "\"$263A'\""},
      {"Main0.c", "'x'"},          {"Main0.r", "0.1"},         {"Main0.r", "1e+300"},
      {"Main0.r", "-0"},           {"Main0.r", "nan"},         {"Main0.r", "-inf"},
      {"Main0.delay", "-1"},       {"Only", "3.4028235e+38"}};
  for (const auto& [path, text] : cases) {
    EXPECT_EQ(Plant::put(*r, path, text), "") << path << " " << text;
    EXPECT_EQ(value_of(*r, path), text);
  }
  EXPECT_EQ(Plant::put(*r, "Only", "1e39"), "P7104");
  EXPECT_EQ(Plant::put(*r, "Main0.name", "bare"), "");
  EXPECT_EQ(value_of(*r, "Main0.name"), "'bare'");
  EXPECT_EQ(Plant::put(*r, "Main0.name", "'$Z'"), "P7103");
  EXPECT_EQ(Plant::put(*r, "Main0.delay", "T#1s500ms"), "");
  EXPECT_EQ(value_of(*r, "Main0.delay"), "1500000000");
  EXPECT_EQ(Plant::put(*r, "Main0.delay", "t#-2.5ms"), "");
  EXPECT_EQ(value_of(*r, "Main0.delay"), "-2500000");
  EXPECT_EQ(Plant::put(*r, "Main0.delay", "T#1ms1s"), "P7103");
  EXPECT_EQ(Plant::put(*r, "Main0.delay", "T#999999999d"), "P7104");
}

TEST(Access, DatesAreTakenAsTheyAreWritten) {
  const std::pair<TypeId, const char*> cases[] = {{TypeId::kDate, "D#2024-02-29"},
                                                  {TypeId::kTod, "TOD#12:34:56.789"},
                                                  {TypeId::kDt, "DT#1969-12-31-23:59:59"},
                                                  {TypeId::kLdate, "LD#2024-02-29"}};
  for (const auto& [id, text] : cases) {
    bytecode::ImageType type;
    type.elementary = id;
    type.size = 8;
    std::array<std::byte, 8> bytes{};
    EXPECT_FALSE(runtime::parse_value(type, text, bytes)) << text;
    std::string again;
    runtime::append_value(type, bytes.data(), again, runtime::ValueStyle::kNames);
    EXPECT_EQ(again, text);
    EXPECT_TRUE(runtime::parse_value(type, "2024-02-30", bytes)) << text;
  }
}

}  // namespace
}  // namespace plc::test
