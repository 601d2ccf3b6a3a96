// plc-run in real time. Times are not judged here, only that it starts, stops and says what it did.
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "tests/support/plc_run.h"
#include "tests/tools/fixture.h"

namespace plc::test {
namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

TEST(Run, EndsAfterItsCyclesWithATable) {
  const auto result = run_plant({tank(), "--cycles", "5", "--stats"});
  ASSERT_EQ(result.code, 0) << result.err;
  for (const char* word :
       {"options: order=drawing", "task Fast: every 20ms", "real time: ", "\nFast, every 20ms: 5 cycles, ",
        " overruns, ", " p99.9 ", "\n  latency ", "\n  scan ", "\n  response ", "\n  up to ", "MB resident"}) {
    EXPECT_NE(result.out.find(word), std::string::npos) << word << " is not in\n" << result.out;
  }
  const std::string tables = result.out.substr(std::min(result.out.find("\nFast, "), result.out.size()));
  for (const std::string& line : lines_of(tables)) EXPECT_LE(line.size(), 120u) << line;
}

TEST(Run, TheLongestScansFitIntoAConfiguration) {
  const ScratchFolder scratch;
  write_text(scratch.file("two.st"), R"(
PROGRAM Main VAR n: DINT; END_VAR n := n + 1; END_PROGRAM
CONFIGURATION C RESOURCE R ON PLC
  TASK Fast(INTERVAL := T#5ms, PRIORITY := 1);
  TASK Slow_1(INTERVAL := T#10ms, PRIORITY := 2);
  PROGRAM a WITH Fast: Main;
  PROGRAM b WITH Slow_1: Main;
END_RESOURCE END_CONFIGURATION
)");
  const auto result = run_plant({scratch.file("two.st"), "--cycles", "20", "--stats"});
  ASSERT_EQ(result.code, 0) << result.all();
  std::string configuration;
  for (const std::string& line : lines_of(result.out)) {
    if (line.rfind("[tasks.", 0) == 0 || line.rfind("execution = ", 0) == 0) configuration += line + "\n";
  }
  EXPECT_EQ(lines_of(configuration).size(), 4u) << result.out;
  write_text(scratch.file("plc.toml"), configuration);
  const auto check = run_tool({PLC_TOOL, "config", "check", scratch.file("plc.toml"), scratch.file("two.st")});
  EXPECT_EQ(check.code, 0) << configuration << check.all();
}

TEST(Run, StatisticsAsJson) {
  const auto result = run_plant({tank(), "--cycles", "5", "--stats=json"});
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.err.find("task Fast: every 20ms"), std::string::npos) << result.err;
  const auto document = nlohmann::json::parse(result.out, nullptr, false);
  ASSERT_FALSE(document.is_discarded()) << result.out;
  const bool granted = document.at("realtime_priority").get<bool>() && document.at("memory_locked").get<bool>();
  EXPECT_TRUE(granted || !document.at("refused").empty()) << result.out;
  const auto& tasks = document.at("tasks");
  ASSERT_EQ(tasks.size(), 2u) << result.out;
  EXPECT_EQ(tasks[0].at("name"), "Fast");
  EXPECT_EQ(tasks[0].at("period_ns"), 20'000'000);
  EXPECT_EQ(tasks[0].at("cycles"), 5);
  EXPECT_EQ(tasks[0].at("faults"), 0);
  for (const auto& task : tasks) {
    for (const char* quantity : {"latency", "scan", "response"}) {
      const auto& times = task.at(quantity);
      EXPECT_EQ(times.at("count"), task.at("cycles")) << quantity;
      std::uint64_t count = 0;
      std::int64_t before = -1;
      for (const auto& bucket : times.at("buckets")) {
        EXPECT_GT(bucket.at(0).get<std::int64_t>(), before);
        before = bucket.at(0).get<std::int64_t>();
        count += bucket.at(1).get<std::uint64_t>();
      }
      EXPECT_EQ(count, times.at("count")) << quantity;
      EXPECT_GE(before, times.at("max_ns").get<std::int64_t>()) << quantity;
      const char* const ascending[] = {"min_ns", "p50_ns", "p99_ns", "p99_9_ns", "max_ns"};
      for (std::size_t i = 1; i < std::size(ascending); ++i) {
        EXPECT_LE(times.at(ascending[i - 1]), times.at(ascending[i])) << quantity << " " << ascending[i];
      }
    }
  }
}

TEST(Run, SaysWhichEngineRuns) {
  const auto engines = [](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), tank());
    const auto result = run_plant(arguments);
    EXPECT_EQ(result.code, 0) << result.err;
    return result.out;
  };
  EXPECT_NE(engines({"--cycles", "3", "--engine", "interp", "--stats"}).find("engine of Fast: interpreter\n"),
            std::string::npos);
  EXPECT_NE(engines({"--cycles", "3", "--engine", "native", "--stats"}).find("engine of Fast: native\n"),
            std::string::npos);
  const auto document = nlohmann::json::parse(engines({"--cycles", "3", "--stats=json"}), nullptr, false);
  ASSERT_FALSE(document.is_discarded());
  EXPECT_EQ(document.at("tasks").at(0).at("engine"), "native");
}

TEST(Run, JsonHasStdoutForItself) {
  EXPECT_EQ(run_plant({tank(), "--cycles", "1", "--stats=json", "--watch", "Running"}).code, 2);
  EXPECT_EQ(run_plant({tank(), "--cycles", "1", "--stats=xml"}).code, 2);
}

TEST(Run, ADocumentThatIsLostIsNoSuccess) {
  const std::string script = std::string("'") + PLC_RUN_TOOL + "' '" + tank() +
                             "' --modbus off --engineering off --cycles 3 --stats=json > /dev/full";
  const auto result = run_tool({"/bin/bash", "-c", script});
  EXPECT_EQ(result.code, 2) << result.all();
  EXPECT_NE(result.err.find("standard output cannot be written"), std::string::npos) << result.err;
}

TEST(Run, AConfigurationHasAName) {
  const auto result = run_plant({tank(), "--cycles", "1", "--config", ""});
  EXPECT_EQ(result.code, 2) << result.all();
  EXPECT_NE(result.err.find("--config"), std::string::npos) << result.err;
}

TEST(Run, SaysWhatItMeasuredOnSigusr1AndGoesOn) {
  for (const char* stats : {"--stats", "--stats=json"}) {
    // Twice, so that the second one must come from a run that went on; then the end, in good order.
    const std::string script =
        std::string("'") + PLC_RUN_TOOL + "' '" + tank() + "' --modbus off --engineering off " + stats +
        " & p=$!; for i in 1 2; do sleep 0.5; kill -USR1 $p; done; sleep 0.3; kill -INT $p; wait $p";
    const auto result = run_tool({"/bin/bash", "-c", "set -m; " + script});
    ASSERT_EQ(result.code, 0) << stats << ": " << result.all();
    const std::string begin = std::string(stats) == "--stats" ? "Fast, every 20ms: " : "{\"realtime_priority\":";
    std::vector<std::string> reports;
    for (const std::string& line : lines_of(result.err)) {
      if (line.rfind(begin, 0) == 0) reports.push_back(line);
    }
    ASSERT_EQ(reports.size(), 2u) << result.all();
    EXPECT_NE(reports[0], reports[1]) << "no cycle in between";
    EXPECT_NE(result.out.find(begin), std::string::npos) << result.out;
  }
}

TEST(Run, EndsAfterItsDuration) {
  const auto result = run_plant({tank(), "--duration", "150ms"});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find("overruns"), std::string::npos);
}

TEST(Run, RunsAnImage) {
  const ScratchFolder scratch;
  ASSERT_EQ(run_tool({PLC_TOOL, "compile", tank(), "-o", scratch.file("tank.pbc")}).code, 0);
  EXPECT_EQ(run_plant({scratch.file("tank.pbc"), "--cycles", "2"}).code, 0);
}

TEST(Run, StopsInGoodOrderOnSignals) {
  for (const char* signal : {"INT", "TERM"}) {
    // The shell sends the signal half a second after the start.
    const std::string script = std::string("'") + PLC_RUN_TOOL + "' '" + tank() +
                               "' --modbus off --engineering off & p=$!; sleep 0.5; kill -" + signal + " $p; wait $p";
    const auto result = run_tool({"/bin/bash", "-c", "set -m; " + script});
    EXPECT_EQ(result.code, 0) << signal << ": " << result.all();
    EXPECT_NE(result.out.find("overruns"), std::string::npos) << signal << ": " << result.all();
  }
}

TEST(Run, ShowsWhatChangesWithoutATerminal) {
  const auto result = run_plant(
      {tank(), "--stimulus", tank_stimulus(), "--duration", "4s", "--watch", "Running", "--watch", "Sequence.StepA"});
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find("Running=0"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("Running=1"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("Sequence.StepA=1"), std::string::npos) << result.out;
  EXPECT_EQ(result.out.find("\x1b["), std::string::npos) << "escape sequences in a pipe";
}

TEST(Run, AMessageStaysOnTheTerminalAboveWhatIsRedrawn) {
  const ScratchFolder scratch;
  write_text(scratch.file("say.st"), R"(
PROGRAM Main
VAR n : INT; Say : LOG_MSG; END_VAR
  n := n + 1;
  Say(EXECUTE := n = 60, SEVERITY := 1, TEXT := 'half of it');
END_PROGRAM
CONFIGURATION C RESOURCE R ON PLC
  TASK T(INTERVAL := T#10ms, PRIORITY := 0);
  PROGRAM main WITH T : Main;
END_RESOURCE END_CONFIGURATION
)");
  // script makes a terminal.
  const auto result = run_tool({"/usr/bin/script", "-qec",
                                std::string(PLC_RUN_TOOL) + " " + scratch.file("say.st") +
                                    " --watch main.n --modbus off --engineering off --cycles 150",
                                "/dev/null"});
  ASSERT_EQ(result.code, 0) << result.all();
  const std::size_t said = result.out.find("half of it");
  ASSERT_NE(said, std::string::npos) << result.out;
  // The next block begins below it; those before and after it are drawn in place.
  const std::size_t block = result.out.find("\x1b[2K", said);
  ASSERT_NE(block, std::string::npos) << result.out;
  EXPECT_EQ(result.out.substr(said, block - said).find("\x1b[2A"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("\x1b[2A"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("\x1b[2A", block), std::string::npos) << result.out;
}

TEST(Run, AStimulusBeginsAgain) {
  const ScratchFolder scratch;
  write_text(scratch.file("count.st"), R"(
VAR_GLOBAL Push AT %IX0.0 : BOOL; Count : DINT; END_VAR
PROGRAM Main VAR_EXTERNAL Push : BOOL; Count : DINT; END_VAR VAR Edge : R_TRIG; END_VAR
  Edge(CLK := Push);
  IF Edge.Q THEN Count := Count + 1; END_IF
END_PROGRAM
CONFIGURATION C RESOURCE R ON PLC
  TASK T(INTERVAL := T#10ms, PRIORITY := 0);
  PROGRAM main WITH T : Main;
END_RESOURCE END_CONFIGURATION
)");
  write_text(scratch.file("in.csv"), "time_ms,Push\n0,0\n50,1\n100,0\n");
  const std::vector<std::string> once = {
      scratch.file("count.st"), "--stimulus", scratch.file("in.csv"), "--cycles", "100", "--watch", "Count"};
  std::vector<std::string> again = once;
  again.emplace_back("--repeat");
  const ToolResult one = run_plant(once), more = run_plant(again);
  ASSERT_EQ(one.code, 0) << one.all();
  ASSERT_EQ(more.code, 0) << more.all();
  EXPECT_EQ(one.out.find("Count=2"), std::string::npos) << one.out;
  const auto reached = [&](int count) { return more.out.find("Count=" + std::to_string(count)) != std::string::npos; };
  EXPECT_TRUE(reached(7) || reached(8) || reached(9)) << more.out;
  EXPECT_EQ(run_plant({tank(), "--repeat", "--cycles", "3"}).code, 2);
}

TEST(Run, WrongDurationIsAUsageError) {
  for (const char* duration : {"0s", "-5s", "soon", "10 parsecs"}) {
    EXPECT_EQ(run_plant({tank(), std::string("--duration=") + duration}).code, 2) << duration;
  }
}

}  // namespace
}  // namespace plc::test
