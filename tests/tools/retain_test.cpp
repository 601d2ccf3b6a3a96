// RETAIN and PERSISTENT over restarts of plc-run, and plc retain.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/plc_run.h"
#include "tests/tools/fixture.h"

namespace plc::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

bool has(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

std::string project(const std::string& more = {}) {
  return "FUNCTION_BLOCK Counter VAR RETAIN n : INT; END_VAR n := n + 1; END_FUNCTION_BLOCK\n"
         "PROGRAM Main VAR c : ARRAY [1..2] OF Counter; END_VAR VAR_EXTERNAL Total : INT; END_VAR\n"
         "VAR PERSISTENT Hours : DINT; END_VAR VAR RETAIN t : TON; END_VAR\n" +
         more +
         "  c[1](); c[2](); Total := Total + 1; Hours := Hours + 1; t(IN := TRUE, PT := T#1h); END_PROGRAM\n"
         "VAR_GLOBAL RETAIN Total : INT; END_VAR\n"
         "CONFIGURATION C RESOURCE R ON PLC TASK T(INTERVAL := T#10ms, PRIORITY := 0); PROGRAM main WITH T : Main; "
         "END_RESOURCE END_CONFIGURATION\n";
}

struct Plant {
  ScratchFolder scratch;
  std::string file = scratch.file("plant.st"), state = scratch.file("state");

  explicit Plant(const std::string& text = project()) { write_text(file, text); }
  ToolResult run(const std::vector<std::string>& more = {}, const std::string& cycles = "5") const {
    std::vector<std::string> arguments = {PLC_RUN_TOOL, file,  "--cycles",      cycles,
                                          "--modbus",   "off", "--engineering", "off"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_tool(arguments);
  }
  [[nodiscard]] std::vector<std::string> kept() const { return {"--state", state}; }
  /// Values that the file has, by path.
  [[nodiscard]] json stored(const std::string& folder = {}) const {
    const auto shown = run_tool({PLC_TOOL, "retain", folder.empty() ? state : folder, "--json"});
    EXPECT_EQ(shown.code, 0) << shown.all();
    const json document = json::parse(shown.out);
    json values;
    for (const json& variable : document.at("variables")) values[variable.at("path")] = variable.at("value");
    return values;
  }
};

TEST(Retained, ValuesSurviveARestart) {
  const Plant plant;
  const auto first = plant.run(plant.kept());
  ASSERT_EQ(first.code, 0) << first.all();
  EXPECT_TRUE(has(first.out, "retain: warm start, 5 variables in ")) << first.out;
  EXPECT_TRUE(has(first.out, "; nothing stored yet")) << first.out;
  const json before = plant.stored();
  EXPECT_GE(before.at("Total"), 5);
  EXPECT_EQ(before.at("main.c[1].n"), before.at("Total"));
  EXPECT_EQ(before.at("main.Hours"), before.at("Total"));
  const auto second = plant.run(plant.kept());
  ASSERT_EQ(second.code, 0) << second.all();
  EXPECT_TRUE(has(second.out, "; 5 restored, stored 2")) << second.out;
  EXPECT_EQ(second.err, first.err);
  const json after = plant.stored();
  EXPECT_GE(after.at("Total"), before.at("Total").get<int>() + 5);
  EXPECT_EQ(after.at("main.c[2].n"), after.at("Total"));
  // The timer went on: no hour has passed.
  EXPECT_TRUE(after.at("main.t").at("IN"));
  EXPECT_FALSE(after.at("main.t").at("Q"));
}

TEST(Retained, ColdAndOriginStarts) {
  const Plant plant;
  ASSERT_EQ(plant.run(plant.kept(), "50").code, 0);
  ASSERT_EQ(plant.run({"--state", plant.state, "--start", "cold"}).code, 0);
  const json cold = plant.stored();
  EXPECT_LT(cold.at("Total"), 50);
  EXPECT_GE(cold.at("main.Hours"), 55);
  const auto origin = plant.run({"--state", plant.state, "--start=origin"});
  ASSERT_EQ(origin.code, 0) << origin.all();
  EXPECT_TRUE(has(origin.out, "retain: origin start, 5 variables in ")) << origin.out;
  EXPECT_LT(plant.stored().at("main.Hours"), 50);
}

TEST(Retained, AChangedProgramKeepsWhatFitsAndNamesTheRest) {
  const Plant plant;
  ASSERT_EQ(plant.run(plant.kept(), "20").code, 0);
  std::string text = project("VAR RETAIN fresh : INT := 9; END_VAR\n");
  text.replace(text.find("ARRAY [1..2]"), 12, "ARRAY [2..3]");
  text.replace(text.find("c[1]"), 4, "c[3]");
  write_text(plant.file, text);
  const auto run = plant.run(plant.kept());
  ASSERT_EQ(run.code, 0) << run.all();
  EXPECT_TRUE(has(run.err, "warning P7612: main.c[1].n: is not there any more")) << run.err;
  const json values = plant.stored();
  EXPECT_GE(values.at("main.c[2].n"), 25);
  EXPECT_LT(values.at("main.c[3].n"), 20);
  EXPECT_EQ(values.at("main.fresh"), 9);
  EXPECT_GE(plant.stored(plant.state + "/retain.previous").at("main.c[1].n"), 20);
}

TEST(Retained, WithoutAFolderItIsSaidThatNothingIsKept) {
  const Plant plant;
  const std::string image = plant.scratch.file("plant.pbc");
  ASSERT_EQ(run_tool({PLC_TOOL, "compile", plant.file, "-o", image}).code, 0);
  EXPECT_EQ(run_tool({PLC_TOOL, "check", plant.file}).err, "");
  for (const std::string& started : {plant.file, image}) {
    const auto run = run_plant({started, "--cycles", "1"});
    EXPECT_EQ(run.code, 0) << run.all();
    EXPECT_TRUE(has(run.err, "warning P7610: 5 retained variables are not kept")) << run.err;
    EXPECT_TRUE(has(run.err, "main.c[1].n, main.c[2].n, ")) << run.err;
  }
  const auto none = run_plant({tank(), "--cycles", "1"});
  EXPECT_FALSE(has(none.err, "P7610")) << none.err;
}

TEST(Retained, TheFolderOfTheConfigurationAndOfTheService) {
  const Plant plant;
  write_text(plant.scratch.file("plc.toml"), "[retain]\nstate = \"kept\"\ninterval = \"50ms\"\n");
  const std::string configuration = plant.scratch.file("plc.toml");
  ASSERT_EQ(plant.run({"--config", configuration}).code, 0);
  EXPECT_TRUE(fs::exists(plant.scratch.file("kept/retain")));
  // A dry run leaves the values of the plant alone.
  fs::remove_all(plant.scratch.file("kept"));
  const auto dry = plant.run({"--config", configuration, "--simulate-io"});
  EXPECT_TRUE(has(dry.err, "P7610")) << dry.err;
  EXPECT_FALSE(fs::exists(plant.scratch.file("kept")));
  ::setenv("STATE_DIRECTORY", (plant.scratch.file("service") + ":/nowhere").c_str(), 1);
  const auto service = plant.run();
  ::unsetenv("STATE_DIRECTORY");
  ASSERT_EQ(service.code, 0) << service.all();
  EXPECT_TRUE(fs::exists(plant.scratch.file("service/retain")));
}

TEST(Retained, AFileThatCannotBeReadStopsNothing) {
  const Plant plant;
  fs::create_directory(plant.state);
  write_text(plant.state + "/retain", "half a fi");
  const auto run = plant.run(plant.kept());
  ASSERT_EQ(run.code, 0) << run.all();
  EXPECT_TRUE(has(run.err, "error P7611: ")) << run.err;
  EXPECT_TRUE(has(run.err, "initial values")) << run.err;
  EXPECT_TRUE(has(run.out, "; initial values")) << run.out;
  EXPECT_GE(plant.stored().at("Total"), 5);
  EXPECT_TRUE(fs::exists(plant.state + "/retain.previous"));
}

TEST(Retained, AFolderThatCannotBeWrittenStopsNothing) {
  const Plant plant;
  write_text(plant.state, "a file");
  const auto run = plant.run(plant.kept());
  ASSERT_EQ(run.code, 0) << run.all();
  EXPECT_TRUE(has(run.err, "warning: P7613: retained values are not stored")) << run.err;
}

TEST(Retained, IsShownAsItIsKept) {
  const Plant plant(
      "PROGRAM Main VAR n : INT; END_VAR VAR PERSISTENT p : INT; END_VAR VAR NON_RETAIN x : INT; END_VAR\n"
      "  n := n + 1; p := n; x := n; END_PROGRAM\n"
      "CONFIGURATION C RESOURCE R ON PLC TASK T(INTERVAL := T#10ms, PRIORITY := 0); PROGRAM RETAIN main WITH T : Main; "
      "END_RESOURCE END_CONFIGURATION\n");
  ASSERT_EQ(plant.run(plant.kept()).code, 0);
  const std::string shown = run_tool({PLC_TOOL, "retain", plant.state}).out;
  const auto line = [&](const std::string& path) {
    const std::size_t at = shown.find(path + " ");
    return at == std::string::npos ? "" : shown.substr(at, shown.find('\n', at) - at);
  };
  EXPECT_TRUE(has(line("main.n"), " RETAIN")) << shown;
  EXPECT_TRUE(has(line("main.p"), " PERSISTENT")) << shown;
  EXPECT_EQ(line("main.x"), "") << shown;
}

TEST(Retained, IsShownAsTable) {
  const Plant plant;
  ASSERT_EQ(plant.run(plant.kept()).code, 0);
  const auto shown = run_tool({PLC_TOOL, "retain", plant.state + "/retain"});
  ASSERT_EQ(shown.code, 0) << shown.all();
  for (const char* part : {"variable", "main.c[2].n", "PERSISTENT", "main.t.ET", "T#", "DINT"}) {
    EXPECT_TRUE(has(shown.out, part)) << part << " is not in\n" << shown.out;
  }
  EXPECT_EQ(run_tool({PLC_TOOL, "retain", plant.scratch.file("nothing")}).code, 2);
  const auto other = run_tool({PLC_TOOL, "retain", plant.file});
  EXPECT_EQ(other.code, 1);
  EXPECT_TRUE(has(other.err, "error P7611: ")) << other.err;
}

}  // namespace
}  // namespace plc::test
