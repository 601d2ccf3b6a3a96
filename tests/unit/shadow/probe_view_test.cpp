// What somebody sees who looks at a POU in a replica: values at their place, what ran, instances, frames.
#include "shadow/probe_view.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/unit/shadow/looked.h"

namespace plc::test {
namespace {

using bytecode::DrawnSide;
using runtime::ProbedPou;
using shadow::ProbeView;

bytecode::DrawnKey text_at(std::uint32_t line, std::uint32_t column, DrawnSide side = DrawnSide::kOutput) {
  return {0, -1, line, column, 0, side};
}
/// "ran", "not run", or the value.
std::string seen(const ProbeView& view, std::uint32_t line, std::uint32_t column, DrawnSide side = DrawnSide::kOutput) {
  const auto shown = view.at(text_at(line, column, side));
  if (!shown) return "no probe";
  if (!shown->ran) return "not run";
  return shown->known ? view.text(text_at(line, column, side)) : "ran";
}

constexpr const char* kRewritten = R"(PROGRAM Main
VAR a : INT; b : BOOL; q : BOOL; END_VAR
a := 1;
IF b THEN
  a := a + 10;
ELSE
  a := a + 20;
END_IF
q := a > 15;
a := 0;
END_PROGRAM
CONFIGURATION c RESOURCE r ON p TASK t (INTERVAL := T#10ms, PRIORITY := 0);
PROGRAM Main WITH t : Main; END_RESOURCE END_CONFIGURATION
)";

TEST(ProbeView, ShowsEachValueAtItsPlaceAndWhichBranchRan) {
  Looked l(kRewritten);
  ProbeView view = l.look_at("Main");
  ASSERT_TRUE(view.any());
  l.scan();
  EXPECT_EQ(seen(view, 3, 1), "1");
  EXPECT_EQ(seen(view, 4, 4), "FALSE");
  EXPECT_EQ(seen(view, 4, 1, DrawnSide::kWhole), "ran");
  EXPECT_EQ(seen(view, 5, 3, DrawnSide::kWhole), "not run");
  EXPECT_EQ(seen(view, 5, 3), "not run");
  EXPECT_EQ(seen(view, 7, 3, DrawnSide::kWhole), "ran");
  EXPECT_EQ(seen(view, 7, 8), "1");
  EXPECT_EQ(seen(view, 7, 3), "21");
  EXPECT_EQ(seen(view, 9, 1), "TRUE");
  EXPECT_EQ(seen(view, 9, 6), "21");
  EXPECT_EQ(seen(view, 10, 1), "0");
  EXPECT_EQ(seen(view, 10, 2), "no probe");
  view.clear();
  l.set("Main.b", "1");
  l.scan();
  EXPECT_EQ(seen(view, 5, 3), "11");
  EXPECT_EQ(seen(view, 7, 3, DrawnSide::kWhole), "not run");
  EXPECT_EQ(seen(view, 9, 1), "FALSE");
}

TEST(ProbeView, KeepsWhatHappenedUntilTheNextFrame) {
  Looked l(kRewritten);
  ProbeView view = l.look_at("Main");
  l.scan();
  l.set("Main.b", "1");
  l.scan();
  const auto q = view.at(text_at(9, 1));
  EXPECT_TRUE(q->was_on && q->was_off && !q->on);
  EXPECT_EQ(seen(view, 7, 3, DrawnSide::kWhole), "ran");
  view.clear();
  l.scan();
  EXPECT_FALSE(view.at(text_at(9, 1))->was_on);
  EXPECT_EQ(seen(view, 7, 3, DrawnSide::kWhole), "not run");
}

constexpr const char* kInstances = R"(FUNCTION_BLOCK Counter
VAR_INPUT step : INT; END_VAR
VAR n : INT; END_VAR
n := n + step;
END_FUNCTION_BLOCK
FUNCTION Twice : INT
VAR_INPUT x : INT; END_VAR
Twice := x * 2;
END_FUNCTION
PROGRAM Main
VAR one : ARRAY [1..2, 0..1] OF Counter; other : Counter; idle : Counter; i : INT; END_VAR
one[1, 1](step := 3);
i := 2;
one[i, 0](step := 5);
other(step := Twice(4));
END_PROGRAM
CONFIGURATION c RESOURCE r ON p TASK t (INTERVAL := T#10ms, PRIORITY := 0);
PROGRAM Main WITH t : Main; END_RESOURCE END_CONFIGURATION
)";

TEST(ProbeView, TellsInstancesApart) {
  Looked l(kInstances);
  std::string paths;
  for (const shadow::PouInstance& one : shadow::instances_of(l.replica(), l.pou("Counter"))) paths += one.path + " ";
  EXPECT_EQ(paths, "Main.one[1,0] Main.one[1,1] Main.one[2,0] Main.one[2,1] Main.other Main.idle ");
  EXPECT_EQ(shadow::instances_of(l.replica(), l.pou("Counter"), 2).size(), 2u);
  l.look_at("Counter", "Main.one[1,1]");
  l.look_at("Counter", "Main.one[2,0]");
  l.look_at("Counter", "Main.idle");
  l.look_at("Counter", "Main.other");
  l.look_at("Twice");
  for (int n = 0; n < 2; ++n) l.scan();
  EXPECT_EQ(seen({l.replica(), l.views[0]}, 4, 1), "6");
  EXPECT_EQ(seen({l.replica(), l.views[1]}, 4, 1), "10");
  EXPECT_EQ(seen({l.replica(), l.views[2]}, 4, 1), "not run");
  EXPECT_EQ(seen({l.replica(), l.views[3]}, 4, 1), "16");
  EXPECT_EQ(seen({l.replica(), l.views[4]}, 8, 1), "8");
  EXPECT_FALSE(ProbeView(l.replica(), {l.pou("Main"), 0}).any());
}

TEST(ProbeView, AnInstanceThatNobodyCallsDidNotRun) {
  Looked l(R"(FUNCTION_BLOCK Counter
VAR n : INT; END_VAR
n := n + 1;
END_FUNCTION_BLOCK
PROGRAM Main
VAR used, idle : Counter; END_VAR
used();
END_PROGRAM
CONFIGURATION c RESOURCE r ON p TASK t (INTERVAL := T#10ms, PRIORITY := 0);
PROGRAM Main WITH t : Main; END_RESOURCE END_CONFIGURATION
)");
  l.look_at("Counter", "Main.idle");
  l.look_at("Counter", "Main.used");
  l.scan();
  EXPECT_EQ(seen({l.replica(), l.views[0]}, 3, 1), "not run");
  EXPECT_EQ(seen({l.replica(), l.views[1]}, 3, 1), "1");
}

TEST(ProbeView, OfTextsTheBeginningIsTaken) {
  Looked l(R"(PROGRAM Main
VAR long : STRING[200]; wide : WSTRING[100]; short : STRING[5]; n : INT; END_VAR
long := CONCAT(long, '0123456789');
wide := CONCAT(wide, "0123456789");
short := 'abc';
n := n + 1;
END_PROGRAM
CONFIGURATION c RESOURCE r ON p TASK t (INTERVAL := T#10ms, PRIORITY := 0);
PROGRAM Main WITH t : Main; END_RESOURCE END_CONFIGURATION
)");
  const ProbeView view = l.look_at("Main");
  for (int n = 0; n < 9; ++n) l.scan();
  EXPECT_EQ(seen(view, 3, 1).size(), 2 + bytecode::kProbedTextBytes);
  EXPECT_EQ(seen(view, 4, 1).size(), 2 + bytecode::kProbedTextBytes / 2);
  EXPECT_EQ(seen(view, 5, 1), "'abc'");
}

TEST(ProbeView, WhoLooksIsNotSeenInTheTable) {
  for (const Engine& engine : all_engines()) {
    Looked l(kInstances, engine);
    const bool native = l.replica().is_compiled();
    EXPECT_EQ(native, static_cast<bool>(engine.compile));
    const std::uint64_t code = l.replica().link_report().code_bytes;
    l.scan();
    const ProbeView view = l.look_at("Main");
    EXPECT_FALSE(l.replica().is_compiled());
    EXPECT_GT(l.replica().link_report().code_bytes, code);
    for (int n = 0; n < 3; ++n) l.scan();  // compares the tables
    EXPECT_EQ(seen(view, 13, 1), "2");
    EXPECT_FALSE(l.replica().look_at({}));
    EXPECT_EQ(l.replica().probes(), nullptr);
    EXPECT_EQ(l.replica().is_compiled(), native);
    EXPECT_EQ(l.replica().link_report().code_bytes, code);
    for (int n = 0; n < 3; ++n) l.scan();
  }
}

TEST(ProbeView, OnlyReplicasAreLookedAt) {
  Looked l(kInstances);
  const std::vector<ProbedPou> views = {{l.pou("Main"), 0}};
  EXPECT_TRUE(l.live->program(0).look_at(views));
}

TEST(ProbeView, MapsComeBackFromFilesAndListings) {
  const Looked l(kInstances);
  const bytecode::Image& image = l.image->image();
  ASSERT_EQ(image.probes.size(), image.pous.size());
  const std::vector<std::byte> file = bytecode::save(image);
  const auto loaded = bytecode::load(file);
  ASSERT_TRUE(loaded);
  EXPECT_EQ(loaded->probes, image.probes);
  const auto listed = bytecode::assemble(bytecode::disassemble(image));
  ASSERT_TRUE(listed);
  EXPECT_EQ(listed->probes, image.probes);
  const std::vector<std::byte> packed = bytecode::pack_probes(image.probes);
  for (std::size_t n = 0; n < packed.size(); ++n) {
    std::vector<bytecode::PouProbes> cut;
    EXPECT_FALSE(bytecode::unpack_probes(std::span(packed).first(n), cut)) << n;
  }
}

}  // namespace
}  // namespace plc::test
