// plc-run with several tasks: what plc.toml says about them, and that a fault of one leaves the others alone.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "io-drivers/config/plan_tasks.h"
#include "tests/support/golden.h"
#include "tests/support/plc_run.h"
#include "tests/tools/fixture.h"

namespace plc::test {
namespace {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// Fast (10 ms) and Slow (100 ms) count. Bad (50 ms) sets its outputs, works well for ten scans, and then runs
/// `trouble`.
std::string plant(const std::string& trouble) {
  return "TYPE Curve : ARRAY[1..100000] OF LREAL; END_TYPE\n"
         "PROGRAM Counting\n"
         "VAR_EXTERNAL FastCount : DINT; END_VAR\n"
         "  FastCount := FastCount + 1;\n"
         "END_PROGRAM\n"
         "PROGRAM Reporting\n"
         "VAR_EXTERNAL FastCount, SlowCount, Seen : DINT; END_VAR\n"
         "  SlowCount := SlowCount + 1;\n"
         "  Seen := FastCount;\n"
         "END_PROGRAM\n"
         "PROGRAM Milling\n"
         "VAR_EXTERNAL Speed : INT; Valve : BOOL; FastCount : DINT; END_VAR\n"
         "VAR Scans, Pass : DINT; Samples, Smooth : Curve; END_VAR\n"
         "  Speed := 1500;\n"
         "  Valve := TRUE;\n"
         "  Scans := Scans + 1;\n"
         "  IF Scans > 10 THEN\n" +
         trouble +  // line 18
         "  END_IF;\n"
         "END_PROGRAM\n"
         "CONFIGURATION C\n"
         "  VAR_GLOBAL\n"
         "    Speed AT %QW0 : INT; Valve AT %QX0.0 : BOOL; FastCount, SlowCount, Seen : DINT;\n"
         "  END_VAR\n"
         "  RESOURCE R ON PLC\n"
         "    TASK Fast(INTERVAL := T#10ms, PRIORITY := 0);\n"
         "    TASK Bad(INTERVAL := T#50ms, PRIORITY := 1);\n"
         "    TASK Slow(INTERVAL := T#100ms, PRIORITY := 2);\n"
         "    PROGRAM counting WITH Fast : Counting;\n"
         "    PROGRAM milling WITH Bad : Milling;\n"
         "    PROGRAM reporting WITH Slow : Reporting;\n"
         "  END_RESOURCE\n"
         "END_CONFIGURATION\n";
}
/// Copies of 800 kB, one a turn: few turns, much time.
std::string copies(int count) {
  return "    FOR Pass := 1 TO " + std::to_string(count) + " DO Smooth := Samples; END_FOR;\n";
}
const std::string kForever = copies(100'000);
const std::string kTooLong = copies(10'000);

constexpr const char* kOutputs =
    "[drivers.bench]\nkind = \"simulated\"\n"
    "[outputs]\nSpeed = { driver = \"bench\", safe = -7 }\nValve = { driver = \"bench\" }\n"
    "[modbus]\nlisten = \"off\"\n";

ToolResult run(const std::string& project, const std::string& toml, std::vector<std::string> more) {
  const ScratchFolder scratch;
  write_text(scratch.file("plant.st"), project);
  write_text(scratch.file("plc.toml"), kOutputs + toml);
  std::vector<std::string> arguments = {scratch.file("plant.st"), "--config", scratch.file("plc.toml")};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_plant(arguments);
}

using Values = std::map<std::string, std::string>;

/// What --watch showed, one entry for each line: the values of all variables at that time.
std::vector<Values> watched(const std::string& out) {
  std::vector<Values> all;
  std::istringstream lines(out);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t begin = line.find(" s ");
    if (begin == std::string::npos || !contains(line, "=")) continue;
    Values values = all.empty() ? Values{} : all.back();
    std::istringstream changes(line.substr(begin + 3));
    bool good = true;
    for (std::string change; changes >> change;) {
      const std::size_t equals = change.find('=');
      if (equals == std::string::npos)
        good = false;
      else
        values[change.substr(0, equals)] = change.substr(equals + 1);
    }
    if (good) all.push_back(std::move(values));
  }
  return all;
}

/// Cycles of a task, by its block at the end ("Fast, every 1ms: 963 cycles, .."); -1 when it is not there.
long cycles(const std::string& out, const std::string& task) {
  const std::size_t block = out.rfind("\n" + task + ", ");
  const std::size_t count = out.find(": ", block == std::string::npos ? out.size() : block);
  return count == std::string::npos ? -1 : std::stol(out.substr(count + 2));
}

struct Trouble {
  const char* name;
  const char* code;  ///< that the fault has
  std::string body;  ///< of the task, after ten good scans
  std::string toml;  ///< of the task
  const char* coherence;
  std::vector<std::string> options;
};
std::ostream& operator<<(std::ostream& out, const Trouble& trouble) { return out << trouble.name; }

class FaultOfOneTask : public ::testing::TestWithParam<Trouble> {};

TEST_P(FaultOfOneTask, LeavesTheOthersAloneAndItsOutputsSafe) {
  const Trouble& trouble = GetParam();
  std::vector<std::string> options = {"--duration", "2500ms", "--coherence", trouble.coherence};
  for (const char* variable : {"Speed", "Valve", "FastCount", "SlowCount"}) {
    options.insert(options.end(), {"--watch", variable});
  }
  options.insert(options.end(), trouble.options.begin(), trouble.options.end());
  ToolResult result = run(plant(trouble.body), trouble.toml, options);
  // A machine that stands still for an interval makes such a fault by itself, before the bad scan: then once more.
  for (int more = 3; more > 0 && contains(result.err, trouble.code) && cycles(result.out, "Bad") < 11; --more) {
    result = run(plant(trouble.body), trouble.toml, options);
  }
  if (contains(result.err, "P7604")) GTEST_SKIP() << "priority ceilings need real-time priorities, and there are none";
  EXPECT_EQ(result.code, 1) << result.all();
  // What happened, where: code, task, file and line, POU.
  const std::size_t at = result.err.find(std::string("fault ") + trouble.code + ": ");
  ASSERT_NE(at, std::string::npos) << result.all();
  const std::string fault = result.err.substr(at, result.err.find('\n', at) - at);
  EXPECT_TRUE(contains(fault, " in task Bad, ")) << fault;
  EXPECT_TRUE(contains(fault, "plant.st:18:")) << fault;
  EXPECT_TRUE(contains(fault, "[POU Milling]")) << fault;
  EXPECT_EQ(result.err.find("fault ", at + 1), std::string::npos) << "one fault, and the task stays stopped";

  const std::vector<Values> seen = watched(result.out);
  const auto working = std::find_if(seen.begin(), seen.end(), [](const Values& v) { return v.at("Speed") == "1500"; });
  ASSERT_NE(working, seen.end()) << result.all();
  EXPECT_EQ(working->at("Valve"), "1");
  const auto safe = std::find_if(working, seen.end(), [](const Values& v) { return v.at("Speed") == "-7"; });
  ASSERT_NE(safe, seen.end()) << "the declared safe value\n" << result.all();
  EXPECT_EQ(safe->at("Valve"), "0") << "what declares none goes to FALSE";
  EXPECT_EQ(seen.back().at("Speed"), "-7") << "and stays so";
  EXPECT_EQ(seen.back().at("Valve"), "0");

  // The cycle counters of the others continue after the fault.
  EXPECT_GE(std::stol(seen.back().at("FastCount")), std::stol(safe->at("FastCount")) + 10) << result.out;
  EXPECT_GE(std::stol(seen.back().at("SlowCount")), std::stol(safe->at("SlowCount")) + 2) << result.out;
  EXPECT_GT(cycles(result.out, "Fast"), 2 * cycles(result.out, "Bad")) << result.out;
  EXPECT_EQ(cycles(result.out, "Bad"), 11) << "ten good scans and the bad one\n" << result.out;
  EXPECT_GT(cycles(result.out, "Slow"), 2) << result.out;
}

INSTANTIATE_TEST_SUITE_P(
    Run, FaultOfOneTask,
    ::testing::Values(
        Trouble{"Watchdog", "R1002", kForever, "[tasks.Bad]\nwatchdog = \"40ms\"\n", "wait-free", {}},
        Trouble{
            "WatchdogUnderCeilings", "R1002", kForever, "[tasks.Bad]\nwatchdog = \"40ms\"\n", "priority-ceiling", {}},
        Trouble{"WatchdogUnderTheLock", "R1002", kForever, "[tasks.Bad]\nwatchdog = \"40ms\"\n", "global-lock", {}},
        Trouble{"Overrun", "R1003", kTooLong, "[tasks.Bad]\noverrun = \"fault\"\n", "wait-free", {}},
        Trouble{"LoopBudget", "R1001", kTooLong, "", "wait-free", {"--loop-budget", "10"}}),
    [](const auto& param) { return param.param.name; });

TEST(RunTasks, APolicyOfATaskCountsBeforeThatOfTheCommandLine) {
  const ToolResult result = run(plant(kTooLong), "[tasks.Bad]\non_fault = \"continue\"\n",
                                {"--duration", "1500ms", "--on-fault", "stop", "--loop-budget", "10"});
  EXPECT_EQ(result.code, 1) << result.all();
  EXPECT_GT(cycles(result.out, "Bad"), 12) << "released again after its faults\n" << result.all();
  EXPECT_TRUE(contains(result.err, "cycle 10,")) << "counted from 0: " << result.err;
  EXPECT_TRUE(contains(result.err, "cycle 11,")) << result.err;
}

TEST(RunTasks, StopOfATaskEndsTheRun) {
  const ToolResult result = run(plant(kForever), "[tasks.Bad]\non_fault = \"stop\"\nwatchdog = \"40ms\"\n",
                                {"--duration", "1h", "--on-fault", "continue"});
  EXPECT_EQ(result.code, 1) << "not killed: " << result.all();
  EXPECT_TRUE(contains(result.err, "fault R1002: ")) << result.err;
}

TEST(RunTasks, WithoutAWatchdogALongScanIsOnlyCounted) {
  const ToolResult result = run(plant(copies(3'000)), "", {"--duration", "2s"});
  EXPECT_EQ(result.code, 0) << result.all();
  EXPECT_FALSE(contains(result.err, "fault")) << result.err;
  EXPECT_TRUE(contains(result.err, "warning P7605: ")) << "it was to be expected\n" << result.err;
  EXPECT_GT(cycles(result.out, "Bad"), 10);
}

TEST(RunTasks, StartLinesSayWhatThisMachineMakesOfTheTasks) {
  const std::vector<int> cpus = io::available_cpus();
  ASSERT_FALSE(cpus.empty());
  const std::string cpu = std::to_string(cpus.back());
  const ToolResult result =
      run(plant(""),
          "[scheduler]\npriorities = \"rate-monotonic\"\n[tasks.Bad]\noffset = \"3ms\"\nlead = \"30us\"\n"
          "watchdog = \"5s\"\npriority = 9\n[tasks.Slow]\ncpu = " +
              cpu + "\n",
          {"--cycles", "20"});
  EXPECT_EQ(result.code, 0) << result.all();
  EXPECT_TRUE(contains(result.out, "\ntask Fast: every 10ms, priority 0\n")) << result.out;
  EXPECT_TRUE(contains(result.out, "\ntask Bad: every 50ms, priority 9, offset 3ms, lead 30us, watchdog 5s\n"))
      << result.out;
  EXPECT_TRUE(contains(result.out, "\ntask Slow: every 100ms, priority 2, processor " + cpu + "\n")) << result.out;
}

TEST(RunTasks, RateMonotonicPrioritiesReplaceThoseOfTheProject) {
  std::string project = plant("");
  const std::size_t fast = project.find("T#10ms, PRIORITY := 0");
  project.replace(fast, 21, "T#10ms, PRIORITY := 7");
  const ToolResult as_it_is = run(project, "", {"--cycles", "2"});
  EXPECT_TRUE(contains(as_it_is.out, "\ntask Fast: every 10ms, priority 7\n")) << as_it_is.all();
  const ToolResult monotonic = run(project, "[scheduler]\npriorities = \"rate-monotonic\"\n", {"--cycles", "2"});
  EXPECT_TRUE(contains(monotonic.out, "\ntask Fast: every 10ms, priority 0\n")) << monotonic.all();
  EXPECT_TRUE(contains(monotonic.out, "\ntask Bad: every 50ms, priority 1\n")) << monotonic.all();
}

TEST(RunTasks, AnOffsetDelaysTheFirstRelease) {
  const ToolResult result = run(plant(""), "[tasks.Slow]\noffset = \"1h\"\n", {"--cycles", "30"});
  EXPECT_EQ(result.code, 0) << result.all();
  EXPECT_EQ(cycles(result.out, "Slow"), 0) << result.out;
  EXPECT_GE(cycles(result.out, "Fast"), 30) << result.out;
}

TEST(RunTasks, AnUnknownTaskIsAnErrorAtItsLine) {
  const ToolResult result = run(plant(""), "[tasks.Fats]\n", {"--cycles", "2"});
  EXPECT_EQ(result.code, 1);
  EXPECT_TRUE(contains(result.err, "plc.toml:8:")) << result.err;
  EXPECT_TRUE(contains(result.err, "P7601")) << result.err;
}

TEST(RunTasks, WhatIsBoundToTheProjectIsReportedAtItsLineToo) {
  const ToolResult result = run(plant(""), "[outputs.Nothing]\ndriver = \"bench\"\n", {"--cycles", "2"});
  EXPECT_EQ(result.code, 1);
  EXPECT_TRUE(contains(result.err, "plc.toml:8:")) << result.err;
  EXPECT_TRUE(contains(result.err, "P7320")) << result.err;
}

TEST(RunTasks, WarningsOfThePlanAndOfTheBindingAreSaidOnceEach) {
  std::string project = plant("");
  const std::string speed = "Speed AT %QW0 : INT;";
  project.insert(project.find(speed), "Spare AT %QX9.0 : BOOL; ");
  const std::string name = "Speed : INT; ";
  project.insert(project.find(name), "Spare : BOOL; ");
  project.insert(project.find("  Speed := 1500;"), "  Spare := TRUE;\n");
  const ToolResult result =
      run(project, "[scheduler]\nunfit = \"run\"\n[tasks.Slow]\nexecution = \"200ms\"\n", {"--cycles", "2"});
  EXPECT_EQ(result.code, 0) << result.all();
  for (const char* said : {"plc.toml:10:8: warning P7605: ", "plc.toml:3:1: warning P7326: "}) {
    const std::size_t first = result.err.find(said);
    EXPECT_NE(first, std::string::npos) << said << '\n' << result.err;
    EXPECT_EQ(result.err.rfind(said), first) << result.err;
  }
}

TEST(RunTasks, EveryProtocolRuns) {
  for (const char* coherence : {"wait-free", "global-lock", "priority-ceiling"}) {
    const ToolResult result = run(plant(""), "", {"--cycles", "30", "--coherence", coherence, "--watch", "Seen"});
    if (contains(result.err, "P7604"))
      GTEST_SKIP() << "priority ceilings need real-time priorities, and there are none";
    EXPECT_EQ(result.code, 0) << coherence << ": " << result.all();
    EXPECT_TRUE(contains(result.out, std::string("coherence=") + coherence + " ")) << result.out;
    const std::vector<Values> seen = watched(result.out);
    ASSERT_FALSE(seen.empty()) << result.out;
    EXPECT_GT(std::stol(seen.back().at("Seen")), 0) << coherence << ": Slow has what Fast counts";
    if (std::string(coherence) == "priority-ceiling") {
      EXPECT_TRUE(contains(result.out, "\ntask Slow: every 100ms, priority 2, processor ")) << "all on one processor";
    }
  }
}

TEST(RunTasks, TheExampleMakesAPart) {
  const std::vector<int> cpus = io::available_cpus();
  if (std::find(cpus.begin(), cpus.end(), 0) == cpus.end()) GTEST_SKIP() << "its plc.toml names processor 0";
  const std::string folder = PLC_EXAMPLES "/three_tasks/";
  const ToolResult result = run_plant({folder + "press.st", "--config", folder + "plc.toml", "--duration", "2500ms",
                                       "--watch", "Parts", "--watch", "Clamp"});
  ASSERT_EQ(result.code, 0) << result.all();
  const std::vector<Values> seen = watched(result.out);
  ASSERT_FALSE(seen.empty()) << result.out;
  EXPECT_TRUE(std::any_of(seen.begin(), seen.end(), [](const Values& v) { return v.at("Clamp") == "1"; }))
      << result.out;
  EXPECT_EQ(seen.back().at("Clamp"), "0") << result.out;
  EXPECT_EQ(seen.back().at("Parts"), "1") << result.out;
  // Its pages show what it prints.
  for (const char* page : {"examples/three_tasks/README.md", "docs/guides/tasks.md"}) {
    const std::string text = read_text((source_root() / page).string());
    for (const char* task : {"task Control: ", "task Station: ", "task Report: "}) {
      const std::size_t at = result.out.find(task);
      ASSERT_NE(at, std::string::npos) << result.out;
      const std::string line = "    " + result.out.substr(at, result.out.find('\n', at) + 1 - at);
      EXPECT_TRUE(contains(text, line)) << page << " does not have\n" << line;
    }
  }
}

}  // namespace
}  // namespace plc::test
