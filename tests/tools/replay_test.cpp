// plc sim --record, recordings of plc-run, and plc replay.
#include <gtest/gtest.h>

#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/golden.h"
#include "tests/support/plc_run.h"
#include "tests/tools/fixture.h"

namespace plc::test {
namespace {

bool has(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

std::string three_tasks() { return PLC_EXAMPLES "/three_tasks/press.st"; }

/// A program that calls functions of the C library, which differ between processors in their last bit.
std::string arithmetic() {
  return "PROGRAM Main\n"
         "VAR x : LREAL; i : INT; a, b, c, d, e : ARRAY[1..200] OF LREAL; END_VAR\n"
         "  FOR i := 1 TO 200 DO\n"
         "    x := x + 0.0137;\n"
         "    a[i] := SIN(x); b[i] := COS(x); c[i] := TAN(x); d[i] := EXP(x / 10.0); e[i] := ATAN(x);\n"
         "  END_FOR;\n"
         "END_PROGRAM\n"
         "CONFIGURATION C RESOURCE R ON PLC TASK T(INTERVAL := T#10ms, PRIORITY := 0); PROGRAM main WITH T : Main; "
         "END_RESOURCE END_CONFIGURATION\n";
}

/// Divides by zero in its 20th scan, and loops for ever in its 30th.
std::string troubled() {
  return "PROGRAM Main\n"
         "VAR n, q : INT; END_VAR\n"
         "  n := n + 1;\n"
         "  IF n = 20 THEN q := 1 / (n - 20); END_IF\n"
         "  WHILE n >= 30 DO q := q + 1; END_WHILE\n"
         "END_PROGRAM\n"
         "CONFIGURATION C RESOURCE R ON PLC TASK T(INTERVAL := T#10ms, PRIORITY := 0); PROGRAM main WITH T : Main; "
         "END_RESOURCE END_CONFIGURATION\n";
}

/// Tells every 10th scan of two blocks, one of them in a function block; by wires, texts and values.
std::string telling() {
  return "FUNCTION_BLOCK Alarm\n"
         "VAR_INPUT Number : DINT; END_VAR\n"
         "VAR Message : LOG_MSG; END_VAR\n"
         "  Message(EXECUTE := Number MOD 10 = 5, SEVERITY := 2, TEXT := CONCAT('alarm {1}', ' of {2}'), VALUE1 := "
         "Number,\n"
         "          VALUE2 := 0.5);\n"
         "END_FUNCTION_BLOCK\n"
         "PROGRAM Main\n"
         "VAR n : DINT; Message : LOG_MSG; Inner : Alarm; END_VAR\n"
         "  n := n + 1;\n"
         "  Message(EXECUTE := n MOD 10 = 0, TEXT := 'scan {1}', VALUE1 := n);\n"
         "  Inner(Number := n);\n"
         "END_PROGRAM\n"
         "CONFIGURATION C RESOURCE R ON PLC TASK T(INTERVAL := T#10ms, PRIORITY := 0); PROGRAM main WITH T : Main; "
         "END_RESOURCE END_CONFIGURATION\n";
}

/// Lines of LOG_MSG.
std::vector<std::string> told_in(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    if (has(line, ": LOG_MSG ")) lines.push_back(line);
  }
  return lines;
}

TEST(ReplayCommand, TellsWhatTheSimulationToldOnBothEngines) {
  const ScratchFolder scratch;
  write_text(scratch.file("telling.st"), telling());
  std::vector<std::string> expected;
  for (const char* const engine : {"--engine=interp", "--engine=native"}) {
    const std::string record = scratch.file("plant.rec");
    const auto simulated =
        run_tool({PLC_TOOL, "sim", scratch.file("telling.st"), "--cycles", "300", "--record", record, engine});
    ASSERT_EQ(simulated.code, 0) << simulated.all();
    const auto told = told_in(simulated.err);
    ASSERT_EQ(told.size(), 60u) << simulated.err;
    EXPECT_EQ(told[0], "40ms: error: LOG_MSG main.Inner.Message: alarm 5 of 0.5 (task T, scan 4)");
    EXPECT_EQ(told[1], "90ms: note: LOG_MSG main.Message: scan 10 (task T, scan 9)");
    if (expected.empty()) expected = told;
    EXPECT_EQ(told, expected) << engine;
    for (const char* const again : {"--engine=interp", "--engine=native"}) {
      const auto replayed = run_tool({PLC_TOOL, "replay", record, again});
      EXPECT_EQ(replayed.code, 0) << replayed.all();
      EXPECT_EQ(told_in(replayed.err), expected) << engine << " " << again;
    }
    // From the middle of a recording on, where the block has told before.
    const auto later = run_tool({PLC_TOOL, "replay", record, "--from", "1s"});
    const auto some = told_in(later.err);
    ASSERT_EQ(some.size(), 40u) << later.err;
    EXPECT_EQ(some[0], expected[20]);
  }
}

TEST(ReplayCommand, GivesTheTraceOfTheSimulationByteForByte) {
  for (const std::string& file : {tank(), three_tasks()}) {
    const ScratchFolder scratch;
    const std::string record = scratch.file("plant.rec"), trace = scratch.file("sim.csv");
    std::vector<std::string> sim = {PLC_TOOL, "sim", file, "--record", record, "--trace", trace};
    if (file == tank()) {
      sim.insert(sim.end(), {"--stimulus", tank_stimulus()});
    } else {
      sim.insert(sim.end(), {"--cycles", "500"});
    }
    const auto simulated = run_tool(sim);
    ASSERT_EQ(simulated.code, 0) << simulated.all();
    for (const char* const engine : {"--engine=interp", "--engine=native"}) {
      const std::string again = scratch.file("replay.csv");
      const auto replayed = run_tool({PLC_TOOL, "replay", record, "--trace", again, engine});
      EXPECT_EQ(replayed.code, 0) << replayed.all();
      EXPECT_TRUE(has(replayed.out, "every scan gives what it gave")) << replayed.all();
      EXPECT_TRUE(read_text(again) == read_text(trace)) << file << " " << engine;
    }
  }
}

TEST(ReplayCommand, ShowsTheFlowOfAScan) {
  const ScratchFolder scratch;
  const std::string record = scratch.file("plant.rec");
  const auto simulated = run_tool({PLC_TOOL, "sim", tank(), "--record", record, "--stimulus", tank_stimulus()});
  ASSERT_EQ(simulated.code, 0) << simulated.all();
  std::string interpreted;
  for (const char* const engine : {"--engine=interp", "--engine=native"}) {
    const auto flow = run_tool({PLC_TOOL, "replay", record, "--until", "8s", "--flow", "Station", engine});
    EXPECT_EQ(flow.code, 0) << flow.all();
    const std::string shown = flow.out.substr(0, flow.out.find(record));
    EXPECT_TRUE(has(flow.out, "every scan gives what it gave")) << flow.out;
    if (interpreted.empty()) interpreted = shown;
    EXPECT_EQ(shown, interpreted) << engine;
  }
  expect_golden("tests/golden/replay_flow.txt", interpreted);
}

/// Two counters, and a branch that runs in every third scan.
std::string counters() {
  return "FUNCTION_BLOCK Counter\n"
         "VAR_INPUT step : INT; END_VAR\n"
         "VAR n : INT; END_VAR\n"
         "n := n + step;\n"
         "IF n MOD 3 = 0 THEN\n"
         "  step := 0;\n"
         "END_IF\n"
         "END_FUNCTION_BLOCK\n"
         "PROGRAM Main\n"
         "VAR one, two : Counter; END_VAR\n"
         "one(step := 1); two(step := 2);\n"
         "END_PROGRAM\n"
         "CONFIGURATION C RESOURCE R ON PLC TASK T(INTERVAL := T#10ms, PRIORITY := 0); PROGRAM main WITH T : Main; "
         "END_RESOURCE END_CONFIGURATION\n";
}

TEST(ReplayCommand, ShowsTheFlowOfOneInstance) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("p.st"), record = scratch.file("p.rec");
  write_text(file, counters());
  ASSERT_EQ(run_tool({PLC_TOOL, "sim", file, "--cycles", "20", "--record", record}).code, 0);
  const auto flow = [&](const std::string& wanted, const std::string& until) {
    return run_tool({PLC_TOOL, "replay", record, "--flow", wanted, "--until", until});
  };
  const auto first = flow("Counter:main.one", "20ms");
  EXPECT_EQ(first.code, 0) << first.all();
  EXPECT_TRUE(has(first.out, "Counter on main.one in scan 2 of task \"T\", 20ms after the first")) << first.out;
  EXPECT_TRUE(has(first.out, "4:1")) << first.out;
  EXPECT_TRUE(has(first.out, "0")) << first.out;
  EXPECT_FALSE(has(first.out, "not run")) << first.out;
  const auto second = flow("counter:MAIN.TWO", "30ms");
  EXPECT_TRUE(has(second.out, "not run")) << second.out;

  const auto several = flow("Counter", "30ms");
  EXPECT_EQ(several.code, 1);
  EXPECT_TRUE(has(several.err, "P7101")) << several.err;
  EXPECT_TRUE(has(several.err, "main.one, main.two")) << several.err;
  EXPECT_TRUE(has(flow("Pump", "30ms").err, "POUs are Counter, Main")) << flow("Pump", "30ms").err;
  EXPECT_EQ(flow("Counter:main.three", "30ms").code, 1);
}

TEST(ReplayCommand, SaysWhenARecordingHasNoProbes) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("p.st"), image = scratch.file("p.pbc"), record = scratch.file("p.rec");
  write_text(file, counters());
  ASSERT_EQ(run_tool({PLC_TOOL, "compile", file, "-o", image}).code, 0);
  ASSERT_EQ(run_tool({PLC_TOOL, "sim", image, "--cycles", "20", "--record", record}).code, 0);
  const auto flow = run_tool({PLC_TOOL, "replay", record, "--flow", "Main"});
  EXPECT_EQ(flow.code, 1);
  EXPECT_TRUE(has(flow.err, "does not say where")) << flow.err;
}

TEST(ReplayCommand, StopsAtEventsFaultsAndTimes) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("p.st"), record = scratch.file("p.rec");
  write_text(file, troubled());
  EXPECT_EQ(run_tool({PLC_TOOL, "sim", file, "--cycles", "100", "--record", record}).code, 1) << "it faults";
  const auto values = [&](std::vector<std::string> more) {
    std::vector<std::string> all = {PLC_TOOL, "replay", record, "--watch", "main.n"};
    all.insert(all.end(), more.begin(), more.end());
    const auto result = run_tool(all);
    EXPECT_EQ(result.code, 0) << result.all();
    const std::size_t last = result.out.rfind('\n', result.out.size() - 2);
    return result.out.substr(last + 1);
  };
  EXPECT_EQ(values({"--until", "event"}), "19,190,20\n");
  EXPECT_EQ(values({"--until", "fault"}), "29,290,30\n");
  EXPECT_EQ(values({"--until", "50ms"}), "5,50,6\n");
  EXPECT_EQ(values({}), "29,290,30\n") << "the task was stopped";
  const auto part = run_tool({PLC_TOOL, "replay", record, "--watch", "main.n", "--from", "30ms", "--until", "40ms"});
  EXPECT_EQ(part.out, "cycle,time_ms,main.n\n0,30,4\n1,40,5\n") << "cycles count from --from";
  const auto fault = run_tool({PLC_TOOL, "replay", record});
  EXPECT_TRUE(has(fault.err, "R1001")) << fault.all();
}

TEST(ReplayCommand, ShowsOneInstant) {
  const ScratchFolder scratch;
  const std::string record = scratch.file("p.rec");
  ASSERT_EQ(run_tool({PLC_TOOL, "sim", three_tasks(), "--cycles", "500", "--record", record}).code, 0);
  const auto at = run_tool({PLC_TOOL, "replay", record, "--at", "200ms"});
  EXPECT_EQ(at.code, 0) << at.all();
  EXPECT_TRUE(has(at.out, "200ms after the first recorded one")) << at.out;
  const auto scan = run_tool({PLC_TOOL, "replay", record, "--scan", "3", "--task", "control"});
  EXPECT_EQ(scan.code, 0) << scan.all();
  EXPECT_TRUE(has(scan.out, "after scan 3 of task Control")) << scan.out;
  const auto no_task = run_tool({PLC_TOOL, "replay", record, "--scan", "3", "--task", "Controll"});
  EXPECT_EQ(no_task.code, 2);
  EXPECT_TRUE(has(no_task.err, "Control")) << no_task.all();
  const auto no_scan = run_tool({PLC_TOOL, "replay", record, "--scan", "1000000"});
  EXPECT_EQ(no_scan.code, 2) << no_scan.all();
  EXPECT_EQ(run_tool({PLC_TOOL, "replay", record, "--at", "1s", "--from", "0s"}).code, 2);
}

/// Recorded in the middle: timers that run, inputs that change, and a fault at the end.
TEST(ReplayCommand, APieceBecomesATestThatGivesTheSame) {
  const ScratchFolder scratch;
  const std::string record = scratch.file("plant.rec"), folder = scratch.file("case");
  ASSERT_EQ(run_tool({PLC_TOOL, "sim", tank(), "--record", record, "--stimulus", tank_stimulus()}).code, 0);
  const auto made = run_tool(
      {PLC_TOOL, "replay", record, "--from", "4050ms", "--until", "9s", "--test", folder, "--project", tank()});
  EXPECT_EQ(made.code, 0) << made.all();
  EXPECT_TRUE(has(made.out, "it gives what was recorded")) << made.all();
  // At 4 s both tasks are released, at 4.04 s only one is.
  EXPECT_TRUE(has(made.out, "cycles from 4s on")) << made.out;
  EXPECT_EQ(run_tool({PLC_TOOL, "test", folder}).code, 0);
  // It can fail.
  std::string expected = read_text(folder + "/expected.csv");
  expected.replace(expected.rfind(",0"), 2, ",1");
  write_text(folder + "/expected.csv", expected);
  EXPECT_EQ(run_tool({PLC_TOOL, "test", folder}).code, 1);
  const auto no_project = run_tool({PLC_TOOL, "replay", record, "--test", folder});
  EXPECT_EQ(no_project.code, 2) << no_project.all();
  const auto missing = run_tool({PLC_TOOL, "replay", record, "--test", folder, "--project", scratch.file("no.xml")});
  EXPECT_EQ(missing.code, 2) << missing.all();
}

/// Two tasks that count, one of them after 30 ms, and a timer that is over between two scans.
std::string two_counters() {
  return "PROGRAM Quick\n"
         "VAR n : DINT; On : BOOL; Delay : TON; END_VAR\n"
         "  n := n + 1;\n"
         "  Delay(IN := n > 4, PT := T#250ms);\n"
         "  On := Delay.Q;\n"
         "END_PROGRAM\n"
         "PROGRAM Slow\n"
         "VAR n : DINT; END_VAR\n"
         "  n := n + 1;\n"
         "END_PROGRAM\n"
         "CONFIGURATION C RESOURCE R ON PLC\n"
         "  TASK A(INTERVAL := T#100ms, PRIORITY := 0); TASK B(INTERVAL := T#200ms, PRIORITY := 1);\n"
         "  PROGRAM quick WITH A : Quick; PROGRAM slow WITH B : Slow;\n"
         "END_RESOURCE END_CONFIGURATION\n";
}

/// What plc-run has recorded of it in 2.5 s, with this plc.toml.
std::string recorded_by_plc_run(const ScratchFolder& scratch, const std::string& file, const std::string& toml) {
  const std::string folder = scratch.file("records"), configuration = scratch.file("plc.toml");
  std::filesystem::remove_all(folder);
  write_text(configuration, toml);
  const auto ran = run_plant({file, "--config", configuration, "--duration", "2500ms", "--record", folder});
  EXPECT_EQ(ran.code, 0) << ran.all();
  for (const auto& entry : std::filesystem::directory_iterator(folder)) return entry.path().string();
  return {};
}

// Scans of a plant begin some microseconds after their release, each task at another time; a test has no latencies.
TEST(ReplayCommand, APieceOfAPlantBecomesATestThatGivesTheSame) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("p.st"), folder = scratch.file("case");
  write_text(file, two_counters());
  for (const char* const toml : {"", "[tasks.B]\noffset = \"30ms\"\n"}) {
    ToolResult made;
    // A machine that is busy may begin a scan after the next release.
    for (int attempt = 0; attempt < 3; ++attempt) {
      const std::string record = recorded_by_plc_run(scratch, file, toml);
      std::filesystem::remove_all(folder);
      made = run_tool({PLC_TOOL, "replay", record, "--from", "300ms", "--test", folder, "--project", file, "--watch",
                       "quick.n", "--watch", "quick.On", "--watch", "slow.n"});
      if (made.code == 0) break;
    }
    EXPECT_EQ(made.code, 0) << toml << made.all();
    EXPECT_TRUE(has(made.out, "it gives what was recorded")) << made.all();
    EXPECT_TRUE(has(made.out, "cycles from 200ms on")) << made.out;
    EXPECT_FALSE(has(made.err, "their phases are lost")) << made.err;
    const std::string expected = read_text(folder + "/expected.csv");
    EXPECT_TRUE(has(expected, "cycle,time_ms,quick.n,quick.On,slow.n\n0,0,3,0,2\n1,100,4,0,2\n2,200,5,0,3\n"))
        << expected;
    EXPECT_EQ(run_tool({PLC_TOOL, "test", folder}).code, 0);
  }
}

TEST(ReplayCommand, ATraceOfAPlantCountsFromItsFirstScan) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("p.st");
  write_text(file, two_counters());
  const std::string record = recorded_by_plc_run(scratch, file, "");
  const auto traced = run_tool({PLC_TOOL, "replay", record, "--watch", "quick.n"});
  EXPECT_EQ(traced.code, 0) << traced.all();
  EXPECT_TRUE(has(traced.out, "cycle,time_ms,quick.n\n0,0,")) << traced.out;
}

TEST(ReplayCommand, AFaultBecomesATest) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("p.st"), record = scratch.file("p.rec"), folder = scratch.file("case");
  write_text(file, troubled());
  EXPECT_EQ(run_tool({PLC_TOOL, "sim", file, "--cycles", "100", "--record", record}).code, 1);
  const auto made = run_tool({PLC_TOOL, "replay", record, "--from", "150ms", "--until", "fault", "--test", folder,
                              "--project", file, "--watch", "main.*"});
  EXPECT_EQ(made.code, 0) << made.all();
  const std::string manifest = read_text(folder + "/case.txt");
  EXPECT_TRUE(has(manifest, "fault: R1001 T 14\n")) << manifest;
  EXPECT_TRUE(has(manifest, "event: divide_by_zero 1\n")) << manifest;
  EXPECT_TRUE(has(read_text(folder + "/expected.csv"), "0,0,16,")) << read_text(folder + "/expected.csv");
  // The mended program does not give it any more.
  std::string mended = troubled();
  mended.replace(mended.find("WHILE n >= 30"), 13, "WHILE n >= 90");
  write_text(folder + "/project.st", mended);
  const auto after = run_tool({PLC_TOOL, "test", folder});
  EXPECT_EQ(after.code, 1);
  EXPECT_TRUE(has(after.all(), "R1001")) << after.all();
}

TEST(ReplayCommand, SaysWhatIsWrong) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("p.st"), record = scratch.file("p.rec");
  write_text(file, troubled());
  EXPECT_EQ(run_tool({PLC_TOOL, "sim", file, "--cycles", "5", "--record", record}).code, 0);
  const auto nowhere = run_tool({PLC_TOOL, "replay", scratch.file("none.rec")});
  EXPECT_EQ(nowhere.code, 2);
  EXPECT_TRUE(has(nowhere.err, "P7001")) << nowhere.all();
  const auto wrong = run_tool({PLC_TOOL, "replay", file});
  EXPECT_EQ(wrong.code, 1) << wrong.all();
  EXPECT_TRUE(has(wrong.err, "is no recording")) << wrong.all();
  const auto time = run_tool({PLC_TOOL, "replay", record, "--until", "later"});
  EXPECT_EQ(time.code, 2);
  EXPECT_TRUE(has(time.err, "--until \"later\" is not a duration")) << time.all();
  const auto watch = run_tool({PLC_TOOL, "replay", record, "--watch", "other.*"});
  EXPECT_EQ(watch.code, 2);
  const auto folder = run_tool({PLC_TOOL, "sim", file, "--cycles", "5", "--record", scratch.file("no/p.rec")});
  EXPECT_EQ(folder.code, 2);
  EXPECT_TRUE(has(folder.err, "P7631")) << folder.all();
  // A file whose end is missing is used as far as it goes, and a whole that is not is no success.
  const std::string bytes = read_text(record);
  write_text(record, std::string_view(bytes).substr(0, bytes.size() - 5));
  const auto cut = run_tool({PLC_TOOL, "replay", record});
  EXPECT_EQ(cut.code, 1);
  EXPECT_TRUE(has(cut.err, "are cut or damaged")) << cut.all();
}

TEST(ReplayCommand, PlcRunRecordsAndItsScansGiveTheSame) {
  const ScratchFolder scratch;
  const std::string folder = scratch.file("records");
  const auto ran = run_plant({three_tasks(), "--cycles", "300", "--record", folder});
  ASSERT_EQ(ran.code, 0) << ran.all();
  EXPECT_TRUE(has(ran.out, "recording into " + folder + "/plant-")) << ran.out;
  EXPECT_TRUE(has(ran.out, " scans, 0 left out; ")) << ran.out;
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) files.push_back(entry.path().string());
  ASSERT_EQ(files.size(), 1u);
  EXPECT_EQ(std::filesystem::status(files[0]).permissions(),
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  const auto replayed = run_tool({PLC_TOOL, "replay", files[0]});
  EXPECT_EQ(replayed.code, 0) << replayed.all();
  EXPECT_TRUE(has(replayed.out, "every scan gives what it gave")) << replayed.out;
  EXPECT_TRUE(has(replayed.out, "Control")) << replayed.out;
}

TEST(ReplayCommand, WhatLedToTheDeathOfPlcRunIsSavedAtTheNextStart) {
  const ScratchFolder scratch;
  const std::string state = scratch.file("state");
  const std::vector<std::string> run = {PLC_RUN_TOOL,    three_tasks(), "--modbus", "off",
                                        "--engineering", "off",         "--state",  state};
  const auto with = [&run](std::vector<std::string> before, const std::vector<std::string>& after) {
    before.insert(before.end(), run.begin(), run.end());
    before.insert(before.end(), after.begin(), after.end());
    return run_tool(before);
  };
  // A machine that is busy may need some seconds to the first scan.
  std::string crash;
  for (const char* const seconds : {"2", "5", "20"}) {
    ASSERT_NE(with({"/usr/bin/timeout", "-s", "KILL", seconds}, {}).code, 0);
    const auto next = with({}, {"--cycles", "20"});
    ASSERT_EQ(next.code, 0) << next.all();
    for (const auto& entry : std::filesystem::recursive_directory_iterator(state)) {
      if (entry.path().filename().string().starts_with("crash-")) crash = entry.path().string();
    }
    if (crash.empty()) continue;
    EXPECT_TRUE(has(next.all(), "plc-run has died before this start; what led to it is in " + crash)) << next.all();
    break;
  }
  ASSERT_FALSE(crash.empty());
  const auto replayed = run_tool({PLC_TOOL, "replay", crash});
  EXPECT_EQ(replayed.code, 0) << replayed.all();
  EXPECT_TRUE(has(replayed.out, "every scan gives what it gave")) << replayed.out;
  // That one ended well.
  ASSERT_EQ(with({}, {"--cycles", "20"}).code, 0);
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(state + "/records")) files += entry.exists() ? 1 : 0;
  EXPECT_EQ(files, 1u);
}

TEST(ReplayCommand, APlantRunsWithoutARecordingThatCannotBe) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("no-folder");
  write_text(file, "a file");
  const auto ran = run_plant({three_tasks(), "--cycles", "20", "--record", file});
  EXPECT_EQ(ran.code, 0) << ran.all();
  EXPECT_TRUE(has(ran.err, "no-folder")) << ran.err;
}

TEST(ReplayCommand, AnotherLibraryOfFunctionsIsSaidFirst) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("p.st"), record = scratch.file("p.rec");
  write_text(file, arithmetic());
  ASSERT_EQ(run_tool({PLC_TOOL, "sim", file, "--cycles", "100", "--record", record}).code, 0);
  EXPECT_EQ(run_tool({PLC_TOOL, "replay", record}).code, 0);
  const auto other =
      run_tool({"/usr/bin/env", "GLIBC_TUNABLES=glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2", PLC_TOOL, "replay", record});
  if (!has(other.err, "another library of functions")) GTEST_SKIP() << "this C library has one set of functions";
  EXPECT_EQ(other.code, 1) << other.all();
  EXPECT_TRUE(has(other.err, "P7632")) << other.all();
}

TEST(ReplayCommand, DrawsThePowerFlowOfAScan) {
  const ScratchFolder scratch;
  const std::string record = scratch.file("plant.rec"), picture = scratch.file("main.svg");
  ASSERT_EQ(run_tool({PLC_TOOL, "sim", tank(), "--record", record, "--stimulus", tank_stimulus()}).code, 0);
  const std::string pou = "Station";
  std::string first;
  for (const char* const engine : {"--engine=interp", "--engine=native"}) {
    const auto drawn = run_tool({PLC_TOOL, "replay", record, "--scan", "300", "--flow", pou, "--svg", picture, engine});
    ASSERT_EQ(drawn.code, 0) << drawn.all();
    const std::string svg = read_text(picture);
    EXPECT_TRUE(svg.starts_with("<svg")) << svg.substr(0, 100);
    EXPECT_TRUE(has(svg, pou + " on Sequence in scan 300 of task ")) << svg.substr(0, 600);
    EXPECT_TRUE(has(svg, " on\"")) << "something has power";
    EXPECT_TRUE(has(svg, " off\"")) << "something has none";
    if (first.empty()) first = svg;
    EXPECT_TRUE(svg == first) << engine;
  }
  // Another scan looks otherwise.
  ASSERT_EQ(run_tool({PLC_TOOL, "replay", record, "--scan", "0", "--flow", pou, "--svg", picture}).code, 0);
  EXPECT_FALSE(read_text(picture) == first);
  EXPECT_EQ(run_tool({PLC_TOOL, "replay", record, "--scan", "3", "--svg", picture}).code, 2) << "of which POU?";
}

}  // namespace
}  // namespace plc::test
