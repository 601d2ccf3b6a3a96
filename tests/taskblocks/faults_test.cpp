// plc and plc-run with components of each kind of fault: the message names the component, and where the process lives,
// the other tasks go on.
#include <gtest/gtest.h>

#include <csignal>
#include <ostream>
#include <string>
#include <vector>

#include "tests/taskblocks/libraries.h"

namespace plc::test {
namespace {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

std::size_t occurrences(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

/// Cycles of a task, by its block at the end; -1 when it is not there.
long cycles(const std::string& out, const std::string& task) {
  const std::size_t block = out.rfind("\n" + task + ", ");
  const std::size_t count = out.find(": ", block == std::string::npos ? out.size() : block);
  return count == std::string::npos ? -1 : std::stol(out.substr(count + 2));
}

class Faults : public ::testing::Test {
 protected:
  /// A project with the block, and a plc.toml that names the library; `toml` is the rest of it.
  void write(const std::string& library, const std::string& block = "FAULTY", const std::string& toml = "") {
    installed(scratch, library);
    write_text(project, faulty_project(block));
    write_text(config, toml + "[taskblocks]\nlibraries = [\"" + library +
                           ".so\"]\n[modbus]\nlisten = \"off\"\n[engineering]\nlisten = \"off\"\n");
  }
  ToolResult run(const std::string& library, const std::string& block = "FAULTY", const std::string& toml = "",
                 const std::vector<std::string>& more = {}) {
    write(library, block, toml);
    std::vector<std::string> arguments = {PLC_RUN_TOOL, project, "--config", config, "--duration", "1500ms"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_tool(arguments);
  }
  /// Bad stopped with its eleventh scan, Fast did not.
  static void expect_others_go_on(const ToolResult& result) {
    EXPECT_EQ(cycles(result.out, "Bad"), 11) << result.all();
    EXPECT_GT(cycles(result.out, "Fast"), 65) << "55 are the time of Bad\n" << result.all();
  }

  ScratchFolder scratch;
  std::string project = scratch.file("plant.st");
  std::string config = scratch.file("plc.toml");
};

TEST_F(Faults, AGoodOneHasNone) {
  const ToolResult result = run("good", "FAULTY", "", {"--watch", "faulty.Result"});
  EXPECT_EQ(result.code, 0) << result.all();
  EXPECT_EQ(result.err, "");
  EXPECT_TRUE(contains(result.out, "faulty.Result=")) << result.out;
}

TEST_F(Faults, AThrowIsAFaultOfItsTask) {
  const ToolResult result = run("throws");
  EXPECT_EQ(result.code, 1) << result.all();
  EXPECT_TRUE(contains(result.err, "fault R1004: taskblock failed in task Bad, cycle 10, at ")) << result.err;
  EXPECT_TRUE(contains(result.err, "taskblock FAULTY faulty.component: pressure sensor gone")) << result.err;
  EXPECT_FALSE(contains(result.err, "allocates")) << "throwing takes memory, and is allowed\n" << result.err;
  expect_others_go_on(result);
}

TEST_F(Faults, ABudgetIsMeasured) {
  const ToolResult result = run("late");
  EXPECT_EQ(result.code, 1) << result.all();
  EXPECT_TRUE(contains(result.err, "fault R1005: taskblock exceeded its time budget in task Bad")) << result.err;
  EXPECT_TRUE(contains(result.err, "taskblock FAULTY faulty.component")) << result.err;
  expect_others_go_on(result);
}

TEST_F(Faults, ABudgetIsNotMeasuredInSimulation) {
  write("late");
  const ToolResult result = run_tool({PLC_TOOL, "sim", project, "--config", config, "--cycles", "100"});
  EXPECT_EQ(result.code, 0) << result.all();
}

TEST_F(Faults, TheWatchdogFindsOneThatSpins) {
  const ToolResult result = run("spins", "FAULTY", "[tasks.Bad]\nwatchdog = \"40ms\"\n");
  EXPECT_EQ(result.code, 3) << result.all();
  EXPECT_TRUE(contains(result.err, "fault R1002: watchdog time exceeded in task Bad")) << result.err;
  EXPECT_TRUE(contains(result.err, "taskblock FAULTY faulty.component")) << result.err;
  EXPECT_TRUE(contains(result.err, "task Bad does not end; its outputs are safe")) << result.err;
  EXPECT_GT(cycles(result.out, "Fast"), 65) << result.all();
}

TEST_F(Faults, AllocationsAreSaidOnce) {
  if (PLC_SANITIZED) GTEST_SKIP() << "sanitizers have a malloc of their own";
  const ToolResult result = run("allocates", "FAULTY", "", {"--stats"});
  EXPECT_EQ(result.code, 0) << result.all();
  const std::string warning = "warning: taskblock FAULTY faulty.component allocates memory in its cycle (task Bad)\n";
  EXPECT_EQ(occurrences(result.err, warning), 1u) << result.err;
  EXPECT_TRUE(contains(result.out, "taskblock FAULTY faulty.component: ")) << result.out;
  EXPECT_GT(cycles(result.out, "Bad"), 11) << result.all();
}

TEST_F(Faults, AnOutputOutsideItsRangeIsClampedAndAnEvent) {
  const ToolResult result = run("out_of_range", "FAULTY", "", {"--watch", "faulty.Result"});
  EXPECT_EQ(result.code, 0) << result.all();
  EXPECT_TRUE(contains(result.out, "faulty.Result=250")) << result.out;
  EXPECT_FALSE(contains(result.out, "faulty.Result=1e")) << result.out;
  EXPECT_TRUE(contains(result.err, "event: ")) << result.err;
  EXPECT_TRUE(contains(result.err, "[POU Faulty_]")) << result.err;
}

struct Crash {
  const char* block;
  int signal;
};
void PrintTo(const Crash& crash, std::ostream* out) { *out << crash.block; }

class Crashes : public Faults, public ::testing::WithParamInterface<Crash> {};

TEST_P(Crashes, EndTheProcessAndAreNamed) {
  const Crash& crash = GetParam();
  const ToolResult result = run("crashes", crash.block);
  const std::string line =
      std::string("plc-run: crashed in taskblock ") + crash.block + " faulty.component (task Bad)\n";
  EXPECT_EQ(occurrences(result.err, line), 1u) << result.all();
  if (PLC_SANITIZED) return;  // they report the crash, and exit
  EXPECT_EQ(result.code, -crash.signal) << "as without the line\n" << result.all();
}

INSTANTIATE_TEST_SUITE_P(Run, Crashes,
                         ::testing::Values(Crash{"FAULTY", SIGSEGV}, Crash{"ABORTS", SIGABRT},
                                           Crash{"RECURSES", SIGSEGV}),
                         [](const auto& param) { return param.param.block; });

TEST_F(Faults, OneThatIsNotReadyStopsTheStart) {
  const ToolResult result = run("not_ready");
  EXPECT_EQ(result.code, 1) << result.all();
  EXPECT_TRUE(contains(result.err, "error P7803: taskblock FAULTY of faulty.component: no licence on this machine"))
      << result.err;
  write("not_ready");
  EXPECT_TRUE(contains(run_tool({PLC_TOOL, "sim", project, "--config", config}).err, "P7803"));
  EXPECT_EQ(run_tool({PLC_TOOL, "config", "check", config, project}).code, 0)
      << "nothing is made ready to check a file";
}

TEST_F(Faults, OneThatCrashesBeforeItIsReadyIsNamedToo) {
  const ToolResult result = run("not_ready", "CRASHES_BEFORE");
  EXPECT_TRUE(
      contains(result.err, "plc-run: crashed in taskblock CRASHES_BEFORE faulty.component, while it was made ready\n"))
      << result.all();
  EXPECT_TRUE(PLC_SANITIZED || result.code == -SIGSEGV) << result.code;
}

TEST_F(Faults, APortThatNoProjectCanNameIsAnErrorOfItsLibrary) {
  write("keyword_port");
  const ToolResult result = run_tool({PLC_TOOL, "check", project, "--config", config});
  EXPECT_EQ(result.code, 1) << result.all();
  EXPECT_TRUE(contains(result.err, "error P7801: ")) << result.all();
  EXPECT_TRUE(contains(result.err, "FAULTY cannot be declared in a project: ")) << result.all();
}

TEST_F(Faults, LibrariesThatCannotBeUsedAreErrorsAtTheirLine) {
  write("wrong_abi");
  const std::vector<std::vector<std::string>> commands = {
      {PLC_RUN_TOOL, project, "--config", config},
      {PLC_TOOL, "check", project, "--config", config},
      {PLC_TOOL, "sim", project, "--config", config},
      {PLC_TOOL, "compile", project, "-o", scratch.file("plant.pbc"), "--config", config},
      {PLC_TOOL, "dump", project, "--config", config},
      {PLC_TOOL, "map", project, "--config", config},
      {PLC_TOOL, "explain", project, "--flow", "--config", config},
      {PLC_TOOL, "explain", project, "--schedule", "--config", config},
      {PLC_TOOL, "config", "init", project, "--config", config},
      {PLC_TOOL, "config", "check", config, project}};
  for (const auto& command : commands) {
    const ToolResult result = run_tool(command);
    EXPECT_EQ(result.code, 1) << command_line(command) << '\n' << result.all();
    EXPECT_TRUE(contains(result.err, "plc.toml:2:14: error P7801: ")) << command_line(command) << '\n' << result.all();
  }
}

TEST_F(Faults, EveryCommandThatCompilesTakesTheLibraries) {
  write("good");
  const std::string image = scratch.file("plant.pbc");
  const std::vector<std::vector<std::string>> commands = {
      {PLC_TOOL, "check", project, "--config", config},
      {PLC_TOOL, "compile", project, "-o", image, "--config", config},
      {PLC_TOOL, "sim", image, "--cycles", "20", "--config", config},
      {PLC_TOOL, "sim", project, "--cycles", "20", "--config", config},
      {PLC_TOOL, "dump", project, "--config", config},
      {PLC_TOOL, "map", project, "--config", config},
      {PLC_TOOL, "explain", project, "--flow", "--config", config},
      {PLC_TOOL, "explain", project, "--schedule", "--config", config},
      {PLC_TOOL, "config", "init", project, "--config", config},
      {PLC_TOOL, "config", "check", config, project},
      {PLC_RUN_TOOL, image, "--cycles", "20", "--config", config}};
  for (const auto& command : commands) {
    const ToolResult result = run_tool(command);
    EXPECT_EQ(result.code, 0) << command_line(command) << '\n' << result.all();
  }
  EXPECT_EQ(run_tool({PLC_TOOL, "check", project}).code, 1) << "the block is unknown without it";
  EXPECT_TRUE(contains(run_tool({PLC_TOOL, "sim", image}).err, "P7802")) << "and not on this machine";
}

TEST_F(Faults, AProjectNamesNoCode) {
  write("good");
  EXPECT_EQ(run_tool({PLC_TOOL, "check", project, "--lib", scratch.file("good.so")}).code, 1);
}

TEST_F(Faults, WhatALibraryPrintsWhileItIsTriedStaysOutOfTheOutput) {
  write("leaving_initialiser");
  const ToolResult result = run_tool({PLC_TOOL, "dump", project, "--config", config});
  EXPECT_EQ(result.out, "");
  EXPECT_TRUE(contains(result.err, "it ended the process while it was loaded")) << result.err;
}

}  // namespace
}  // namespace plc::test
