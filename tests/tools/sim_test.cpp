#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/tools/fixture.h"

namespace plc::test {
namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

class Sim : public testing::Test {
 protected:
  void SetUp() override { write_text(project_, small_project()); }
  ScratchFolder scratch_;
  std::string project_ = scratch_.file("small.xml");
};

TEST_F(Sim, StimulusIsAppliedAtTheFirstReleaseAtOrAfterItsTime) {
  const std::string stimulus = scratch_.file("in.csv");
  write_text(stimulus, "time_ms,MAIN.in\n0,0\n15,1\n25,\n30,0\n");
  const auto result =
      run_tool({PLC_TOOL, "sim", project_, "--stimulus", stimulus, "--cycles", "5", "--watch", "main.*"});
  ASSERT_EQ(result.code, 0) << result.err;
  const auto lines = lines_of(result.out);
  ASSERT_EQ(lines.size(), 6u) << result.out;
  EXPECT_EQ(lines[0].substr(0, 14), "cycle,time_ms,");
  // In is 1 from the release at 20 ms on, the empty cell keeps it, 30 ms clears it; Out follows in the same cycle.
  for (const auto& [row, tail] :
       {std::pair(1, ",0,0,0"), {2, ",10,0,0"}, {3, ",20,1,1"}, {4, ",30,0,0"}, {5, ",40,0,0"}}) {
    const std::string& line = lines[static_cast<std::size_t>(row)];
    EXPECT_EQ(line.substr(line.find(',')), tail) << result.out;
  }
}

TEST_F(Sim, RunsUntilTheStimulusEnds) {
  const std::string stimulus = scratch_.file("in.csv");
  write_text(stimulus, "time_ms,main.In\n0,0\n95,1\n");
  const auto result = run_tool({PLC_TOOL, "sim", project_, "--stimulus", stimulus});
  EXPECT_NE(result.out.find("10 cycles"), std::string::npos) << result.out;
}

TEST_F(Sim, TraceFileHoldsWhatWatchSelects) {
  const std::string trace = scratch_.file("out.csv");
  const auto result = run_tool({PLC_TOOL, "sim", project_, "--cycles", "3", "--watch", "*.out", "--trace", trace});
  ASSERT_EQ(result.code, 0) << result.err;
  const auto lines = lines_of(read_text(trace));
  ASSERT_EQ(lines.size(), 4u);
  EXPECT_EQ(lines[0], "cycle,time_ms,main.Out");
}

TEST_F(Sim, EqualRunsGiveEqualTraces) {
  const std::vector<std::string> command = {PLC_TOOL, "sim", tank(), "--stimulus", tank_stimulus(), "--watch", "*"};
  const auto first = run_tool(command);
  EXPECT_EQ(first.code, 0) << first.err;
  EXPECT_EQ(first.out, run_tool(command).out);
}

TEST_F(Sim, StatsNameEveryTask) {
  const auto result = run_tool({PLC_TOOL, "sim", tank(), "--cycles", "50", "--stats"});
  EXPECT_EQ(result.code, 0);
  for (const char* word : {"Fast", "Slow", "scans", "min ns", "median ns", "p99 ns", "MB resident"}) {
    EXPECT_NE(result.out.find(word), std::string::npos) << word << " is not in\n" << result.out;
  }
}

TEST_F(Sim, EnginesGiveEqualTraces) {
  std::vector<std::string> command = {PLC_TOOL,        "sim",     tank(), "--stimulus",
                                      tank_stimulus(), "--watch", "*",    "--engine"};
  command.push_back("interp");
  const auto first = run_tool(command);
  EXPECT_EQ(first.code, 0) << first.err;
  for (const char* engine : {"native", "auto"}) {
    command.back() = engine;
    EXPECT_EQ(first.out, run_tool(command).out) << engine;
  }
  command.back() = "fast";
  EXPECT_EQ(run_tool(command).code, 2);
}

TEST_F(Sim, AConfigurationForAnotherProjectIsRefused) {
  const std::string config = scratch_.file("plc.toml");
  write_text(config, "[tasks.Fsat]\npriority = 3\n");
  const auto result = run_tool({PLC_TOOL, "sim", tank(), "--config", config});
  EXPECT_EQ(result.code, 1);
  EXPECT_NE(result.err.find("1:8: error P7601: the project has no task \"Fsat\""), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("did you mean \"Fast\"?"), std::string::npos) << result.err;
  // Processors of the plant's machine, which this one need not have.
  write_text(config, "[tasks.Fast]\ncpu = 200\n");
  EXPECT_EQ(run_tool({PLC_TOOL, "sim", tank(), "--config", config}).code, 0);
}

TEST_F(Sim, StatsAsJsonNameTheEngine) {
  for (const char* engine : {"interp", "native"}) {
    const auto result = run_tool({PLC_TOOL, "sim", tank(), "--cycles", "50", "--stats=json", "--engine", engine});
    ASSERT_EQ(result.code, 0) << result.err;
    const auto document = nlohmann::json::parse(result.out, nullptr, false);
    ASSERT_FALSE(document.is_discarded()) << result.out;
    const auto& tasks = document.at("tasks");
    ASSERT_EQ(tasks.size(), 2u);
    EXPECT_EQ(tasks[0].at("name"), "Fast");
    EXPECT_EQ(tasks[0].at("engine"), std::string(engine) == "native" ? "native" : "interpreter");
    EXPECT_EQ(tasks[0].at("scans"), 50);
    EXPECT_LE(tasks[0].at("min_ns"), tasks[0].at("median_ns"));
    EXPECT_LE(tasks[0].at("median_ns"), tasks[0].at("p99_ns"));
  }
  EXPECT_EQ(run_tool({PLC_TOOL, "sim", tank(), "--stats=json", "--watch", "*"}).code, 2);
}

TEST_F(Sim, DumpSaysWhatBecameNative) {
  const auto result = run_tool({PLC_TOOL, "dump", "--native", tank()});
  EXPECT_EQ(result.code, 0) << result.err;
  for (const char* word : {"task Fast: ", " bytes of native code", "in the interpreter", "READ_N"}) {
    EXPECT_NE(result.out.find(word), std::string::npos) << word << " is not in\n" << result.out;
  }
}

TEST_F(Sim, AWrongStimulusIsToldWithItsPlace) {
  const std::string stimulus = scratch_.file("in.csv");
  write_text(stimulus, "time_ms,main.In\n0,0\n10,maybe\n");
  const auto result = run_tool({PLC_TOOL, "sim", project_, "--stimulus", stimulus});
  EXPECT_EQ(result.code, 1);
  EXPECT_NE(result.err.find("in.csv:3:"), std::string::npos) << result.err;
  write_text(stimulus, "time_ms,main.Inn\n0,0\n");
  const auto unknown = run_tool({PLC_TOOL, "sim", project_, "--stimulus", stimulus});
  EXPECT_EQ(unknown.code, 1);
  EXPECT_NE(unknown.err.find("main.In"), std::string::npos) << unknown.err;
}

TEST_F(Sim, AStimulusThatCannotBeOpenedIsAnIoProblem) {
  const auto result = run_tool({PLC_TOOL, "sim", project_, "--stimulus", scratch_.file("none.csv")});
  EXPECT_EQ(result.code, 2);
}

TEST_F(Sim, AnImageNeverReplacesItsProject) {
  const auto result = run_tool({PLC_TOOL, "compile", project_, "-o", project_});
  EXPECT_EQ(result.code, 2);
  EXPECT_EQ(run_tool({PLC_TOOL, "check", project_}).code, 0);
}

TEST_F(Sim, LostOutputIsNotSuccess) {
  const auto result = run_tool({"/bin/sh", "-c", std::string(PLC_TOOL) + " dump " + project_ + " > /dev/full"});
  EXPECT_EQ(result.code, 2);
}

TEST_F(Sim, AnUnknownWatchIsTold) {
  const auto result = run_tool({PLC_TOOL, "sim", project_, "--watch", "Nothing*"});
  EXPECT_EQ(result.code, 2);
}

TEST_F(Sim, AProgramWithoutVariablesHasAnEmptyTrace) {
  const std::string file = scratch_.file("empty.st"), trace = scratch_.file("out.csv");
  write_text(
      file,
      "PROGRAM Main ; END_PROGRAM\n"
      "CONFIGURATION C TASK T(INTERVAL := T#10ms, PRIORITY := 0); PROGRAM main WITH T : Main; END_CONFIGURATION\n");
  const auto result = run_tool({PLC_TOOL, "sim", file, "--cycles", "3", "--trace", trace});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(read_text(trace), "cycle,time_ms\n0,0\n1,10\n2,20\n");
  EXPECT_EQ(run_tool({PLC_TOOL, "sim", file, "--cycles", "1", "--watch", "*"}).code, 0);
}

TEST_F(Sim, WithoutAnInstanceItOffersThePous) {
  write_text(project_, small_project(false));
  const auto result = run_tool({PLC_TOOL, "sim", project_});
  EXPECT_EQ(result.code, 1);
  EXPECT_NE(result.err.find("--pou Main"), std::string::npos) << result.err;
  const auto alone = run_tool({PLC_TOOL, "sim", project_, "--pou", "main", "--cycles", "2", "--watch", "*"});
  EXPECT_EQ(alone.code, 0) << alone.err;
  EXPECT_NE(alone.out.find("Main.In"), std::string::npos) << alone.out;
  EXPECT_NE(alone.out.find(",20,"), std::string::npos) << "the task has 20 ms: " << alone.out;
}

TEST_F(Sim, TheExampleMakesABatchAndSoundsTheHorn) {
  const auto result = run_tool({PLC_TOOL, "sim", tank(), "--stimulus", tank_stimulus(), "--watch", "BatchCount",
                                "--watch", "Horn", "--watch", "Mixer", "--watch", "Running"});
  ASSERT_EQ(result.code, 0) << result.err;
  const auto lines = lines_of(result.out);
  ASSERT_EQ(lines[0], "cycle,time_ms,BatchCount,Horn,Mixer,Running");
  // By the script: full at 8.3 s, three seconds of mixing, empty again by 15 s; above 95 % from 17.95 s on.
  const auto row_at = [&](const std::string& time_ms) {
    for (const std::string& line : lines) {
      if (line.find("," + time_ms + ",") != std::string::npos)
        return line.substr(line.find("," + time_ms + ",") + time_ms.size() + 2);
    }
    return std::string("no row");
  };
  EXPECT_EQ(row_at("400"), "0,0,0,0");
  EXPECT_EQ(row_at("9000"), "0,0,1,1");
  EXPECT_EQ(row_at("16000"), "1,0,0,1");
  EXPECT_EQ(row_at("19500").substr(0, 2), "1,");
  EXPECT_EQ(row_at("19500").back(), '0') << "the level alarm stops the station";
  EXPECT_NE(result.out.find(",1,1,0,0\n"), std::string::npos) << "the horn never sounds";
}

}  // namespace
}  // namespace plc::test
