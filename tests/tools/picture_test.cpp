// Drawings on the command line: plc explain --svg of projects and images, plc compile --drawings, plc dump.
#include <gtest/gtest.h>

#include "tests/support/golden.h"
#include "tests/tools/fixture.h"

namespace plc::test {
namespace {

std::string tank() { return PLC_EXAMPLES "/tank/tank.xml"; }

ToolResult explain(std::vector<std::string> more) {
  more.insert(more.begin(), {PLC_TOOL, "explain"});
  return run_tool(more);
}

TEST(ExplainSvg, DrawsAPouOfAProject) {
  const ToolResult all = explain({tank(), "--svg", "-"});
  EXPECT_EQ(all.code, 0) << all.err;
  EXPECT_NE(all.out.find(">program Station (LD)</text>"), std::string::npos);
  EXPECT_NE(all.out.find(">function block RawToUnit (FBD)</text>"), std::string::npos);
  const ToolResult one = explain({tank(), "station", "--svg", "-"});
  EXPECT_EQ(one.code, 0) << one.err;
  EXPECT_NE(one.out.find("<title>Station</title>"), std::string::npos);
  EXPECT_NE(one.out.find(">EmergencyOk</text>"), std::string::npos);
  EXPECT_EQ(one.out.find("RawToUnit"), std::string::npos);
  const ScratchFolder scratch;
  const std::string path = scratch.file("station.svg");
  const ToolResult file = explain({tank(), "Station", "--svg", path});
  EXPECT_EQ(file.code, 0) << file.err;
  EXPECT_EQ(file.out, "");
  EXPECT_EQ(read_text(path), one.out);
  EXPECT_EQ(run_tool({"/bin/sh", "-c", "command -v xmllint >/dev/null || exit 0; xmllint --noout \"$0\"", path}).code,
            0);
}

TEST(ExplainSvg, ThePictureOfTheGuideIsWhatTheCommandDraws) {
  expect_golden("docs/guides/pictures.svg", explain({tank(), "Station", "--svg", "-"}).out);
}

TEST(ExplainSvg, DrawsTextsAndChartsThatAreWritten) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("plant.st");
  write_text(file,
             "PROGRAM Main\nVAR a, b : BOOL; END_VAR\nINITIAL_STEP S1: END_STEP\nSTEP S2: Set(N); END_STEP\n"
             "TRANSITION FROM S1 TO S2 := a < b; END_TRANSITION\nTRANSITION FROM S2 TO S1 := TRUE; END_TRANSITION\n"
             "ACTION Set: b := a; END_ACTION\nEND_PROGRAM\n");
  const ToolResult result = explain({file, "Main", "--svg", "-"});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find(">a &lt; b</text>"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find(">action Main.Set (ST)</text>"), std::string::npos) << result.out;
  const ToolResult action = explain({file, "Main.Set", "--svg", "-"});
  EXPECT_NE(action.out.find(">b := a;</text>"), std::string::npos) << action.out;
  EXPECT_EQ(action.out.find(">S1</text>"), std::string::npos);
}

TEST(ExplainSvg, DrawsWhatAnImageCarries) {
  const ScratchFolder scratch;
  const std::string with = scratch.file("with.pbc"), without = scratch.file("without.pbc");
  ASSERT_EQ(run_tool({PLC_TOOL, "compile", tank(), "--drawings", "-o", with}).code, 0);
  ASSERT_EQ(run_tool({PLC_TOOL, "compile", tank(), "-o", without}).code, 0);
  EXPECT_EQ(explain({with, "Station", "--svg", "-"}).out, explain({tank(), "Station", "--svg", "-"}).out);
  const ToolResult none = explain({without, "--svg", "-"});
  EXPECT_EQ(none.code, 1);
  EXPECT_NE(none.err.find("carries no drawings"), std::string::npos) << none.err;
  EXPECT_NE(none.err.find("--drawings"), std::string::npos) << none.err;
  // Nothing else of the listing is another one.
  const ToolResult dump = run_tool({PLC_TOOL, "dump", with});
  EXPECT_EQ(dump.code, 0) << dump.err;
  EXPECT_NE(dump.out.find("\n; drawings of 5 bodies with 114 elements and 0 statements: "), std::string::npos)
      << dump.out.substr(dump.out.size() - 200);
  std::istringstream lines(dump.out.substr(0, dump.out.find("; drawings")));
  std::string rest;
  for (std::string line; std::getline(lines, line);) {
    // Where the code has what drawings show.
    if (!line.starts_with("probes ")) rest += line + '\n';
  }
  EXPECT_EQ(rest, run_tool({PLC_TOOL, "dump", without}).out);
  // It runs as it does without them.
  EXPECT_EQ(run_tool({PLC_TOOL, "sim", with, "--cycles", "20", "--watch", "*"}).out,
            run_tool({PLC_TOOL, "sim", without, "--cycles", "20", "--watch", "*"}).out);
}

TEST(ExplainSvg, SaysWhatIsNotThere) {
  const ToolResult unknown = explain({tank(), "Staton", "--svg", "-"});
  EXPECT_EQ(unknown.code, 1);
  EXPECT_NE(unknown.err.find("has no drawing of a POU \"Staton\""), std::string::npos) << unknown.err;
  EXPECT_NE(unknown.err.find("it has: RawToUnit, HighAlarm, Measure, Station, Signals"), std::string::npos)
      << unknown.err;
  const ToolResult unwritable = explain({tank(), "--svg", "/nowhere/x.svg"});
  EXPECT_EQ(unwritable.code, 2);
  EXPECT_NE(unwritable.err.find("/nowhere/x.svg cannot be written"), std::string::npos) << unwritable.err;
  EXPECT_EQ(explain({"/nowhere.xml", "--svg", "-"}).code, 2);
  EXPECT_EQ(explain({tank(), "--svg", tank()}).code, 2);
  EXPECT_EQ(explain({tank(), "--svg", "-", "--schedule"}).code, 2);
}

TEST(Recording, CarriesTheDrawings) {
  const ScratchFolder scratch;
  const std::string record = scratch.file("tank.rec");
  ASSERT_EQ(run_tool({PLC_TOOL, "sim", tank(), "--cycles", "5", "--record", record}).code, 0);
  const ToolResult replayed = run_tool({PLC_TOOL, "replay", record});
  EXPECT_EQ(replayed.code, 0) << replayed.err;
  // The image is in the head as it is in a file.
  const std::string bytes = read_text(record);
  const std::size_t image = bytes.find(std::string("PICARD\x1a\n", 8));
  ASSERT_NE(image, std::string::npos);
  const ToolResult direct = run_tool({PLC_TOOL, "compile", tank(), "--drawings", "-o", scratch.file("tank.pbc")});
  ASSERT_EQ(direct.code, 0) << direct.err;
  const std::string compiled = read_text(scratch.file("tank.pbc"));
  EXPECT_EQ(bytes.substr(image, compiled.size()), compiled);
}

}  // namespace
}  // namespace plc::test
