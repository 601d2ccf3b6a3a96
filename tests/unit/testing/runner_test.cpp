// Tests of a project, from text to results: what they see, what they change, and what they are told.
#include "testing/runner.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "testing/coverage.h"

namespace plc::tests {
namespace {

namespace fs = std::filesystem;

/// A project in a file, compiled with its tests and run.
class Project {
 public:
  explicit Project(const std::string& text, bool coverage = false) {
    static int count = 0;
    path_ = (fs::path(::testing::TempDir()) /
             ("runner_" + std::to_string(::getpid()) + "_" + std::to_string(++count) + ".st"))
                .string();
    std::ofstream(path_) << text;
    EXPECT_FALSE(registry_.add(host_library()).has_value());
    compiler::Compilation compilation;
    compiler::Request request;
    request.path = path_;
    request.goal = compiler::Goal::kRun;
    request.taskblocks = &registry_;
    request.tests = true;
    request.coverage = coverage;
    compiler::compile(request, compilation);
    std::ostringstream messages;
    compilation.diagnostics.render(messages);
    messages_ = messages.str();
    sites_ = compilation.cover_sites;
    if (compilation.tests) waivers_ = waivers_of(compilation.tests->pragmas);
    if (!compilation.ok() || !compilation.tests) return;
    RunnerOptions options;
    options.max_cycles = 100'000;
    auto made = Runner::make(std::move(compilation), registry_, std::move(options));
    if (!made) {
      messages_ += made.error().message;
      return;
    }
    runner_ = std::move(*made);
  }
  ~Project() { fs::remove(path_); }

  /// Result of test `index`.
  TestResult run(std::size_t index = 0) {
    EXPECT_NE(runner_, nullptr) << messages_;
    if (runner_ == nullptr) return {};
    auto result = runner_->run(index);
    EXPECT_TRUE(result.has_value());
    return *result;
  }
  [[nodiscard]] const std::string& messages() const { return messages_; }
  [[nodiscard]] CoverageReport coverage() const { return {sites_, runner_->seen(), waivers_}; }

 private:
  std::string path_;
  taskblocks::Registry registry_ = taskblocks::Registry::built_in();
  std::string messages_;
  std::vector<ir::CoverSite> sites_;
  std::vector<Waiver> waivers_;
  std::unique_ptr<Runner> runner_;
};

std::string shown(const TestResult& result) {
  std::string out;
  for (const Failure& f : result.failures)
    out += std::to_string(f.line) + ": " + f.what + ": expected " + f.expected + ", got " + f.got + "\n";
  return out;
}

const std::string kPlant = R"(
FUNCTION_BLOCK Pump
VAR_INPUT Go : BOOL; END_VAR
VAR_OUTPUT Running : BOOL; END_VAR
VAR Starts : INT; Before : BOOL; END_VAR
  Running := Go;
  IF Go AND NOT Before THEN Starts := Starts + 1; END_IF;
  Before := Go;
END_FUNCTION_BLOCK
PROGRAM Main
VAR_EXTERNAL Level : INT; Count : DINT; END_VAR
VAR
  Start AT %IX0.0 : BOOL;
  Lamp AT %QX0.0 : BOOL;
  first : Pump;
  timer : TON;
  List : ARRAY[1..3] OF INT;
END_VAR
  first(Go := Start);
  Lamp := first.Running;
  timer(IN := Start, PT := T#100ms);
  Count := Count + 1;
  List[2] := Level * 2;
END_PROGRAM
CONFIGURATION C
  VAR_GLOBAL Level : INT; Count : DINT; END_VAR
  RESOURCE R ON PLC
    TASK Fast(INTERVAL := T#20ms, PRIORITY := 0);
    PROGRAM main WITH Fast : Main;
  END_RESOURCE
END_CONFIGURATION
)";

std::string with_test(const std::string& statements, const std::string& variables = "") {
  return kPlant + "TEST 'it'\n" + (variables.empty() ? "" : "VAR " + variables + " END_VAR\n") + statements +
         "\nEND_TEST\n";
}

TestResult run(const std::string& statements, const std::string& variables = "") {
  return Project(with_test(statements, variables)).run();
}

void expect_passes(const std::string& statements, const std::string& variables = "") {
  const TestResult result = run(statements, variables);
  EXPECT_TRUE(result.passed()) << statements << "\n" << shown(result);
  EXPECT_GT(result.checks, 0u);
}

TEST(Runner, AnAssertOfTheProjectIsAFailureOfTheTestThatRanIt) {
  const std::string text =
      "FUNCTION Half : INT VAR_INPUT x : INT; END_VAR\n  ASSERT(x MOD 2 = 0);\n  Half := x / 2;\nEND_FUNCTION\n"
      "PROGRAM Main VAR n : INT; END_VAR\n  n := n + 1;\n  ASSERT(n < 3);\nEND_PROGRAM\n"
      "CONFIGURATION C RESOURCE R ON PLC TASK T(INTERVAL := T#20ms, PRIORITY := 0); PROGRAM main WITH T : Main;\n"
      "END_RESOURCE END_CONFIGURATION\n"
      "TEST 'holds' RUN_CYCLES(2); ASSERT_EQ(2, main.n); ASSERT_EQ(2, Half(4)); END_TEST\n"
      "TEST 'does not' RUN_CYCLES(4); ASSERT_EQ(1, Half(3)); ASSERT_EQ(2, Half(5)); END_TEST\n"
      "TEST 'holds again' RUN_CYCLES(1); ASSERT_EQ(1, Half(2)); END_TEST\n";
  Project project(text);
  EXPECT_TRUE(project.run(0).passed()) << shown(project.run(0));
  const TestResult result = project.run(1);
  ASSERT_EQ(result.failures.size(), 2u) << shown(result);
  EXPECT_EQ(result.failures[0].what, "ASSERT of Main did not hold, 2 times");
  EXPECT_EQ(result.failures[0].line, 7u);
  EXPECT_EQ(result.failures[1].what, "ASSERT of Half did not hold, 2 times");
  EXPECT_EQ(result.failures[1].line, 2u);
  EXPECT_TRUE(project.run(2).passed()) << shown(project.run(2));
}

TEST(Runner, AFailureHasPlaceExpectedAndGot) {
  const TestResult result = run("ASSERT_EQ(7, Level, 'full');\nASSERT_TRUE(main.Lamp);\nASSERT_EQ(0, Level);");
  ASSERT_EQ(result.failures.size(), 2u);
  EXPECT_EQ(result.checks, 3u);
  EXPECT_EQ(result.failures[0].what, "Level");
  EXPECT_EQ(result.failures[0].expected, "7");
  EXPECT_EQ(result.failures[0].got, "0");
  EXPECT_EQ(result.failures[0].message, "full");
  EXPECT_EQ(result.failures[1].line, result.failures[0].line + 1);
  EXPECT_EQ(result.failures[1].expected, "TRUE");
  EXPECT_EQ(result.failures[1].got, "FALSE");
}

TEST(Runner, EveryAssertionHoldsAndFails) {
  expect_passes(
      "ASSERT_TRUE(a = 5); ASSERT_FALSE(a = 4); ASSERT_EQ(5, a); ASSERT_NE(4, a); ASSERT_LT(6, a); ASSERT_LE(5, a);"
      "ASSERT_GT(4, a); ASSERT_GE(5, a); ASSERT_NEAR(4.9, r, 0.2); ASSERT_NEAR(T#1s, t, T#10ms); ASSERT_EQ('ab', s);"
      "ASSERT_NEAR(5, a, 0);",
      "a : INT := 5; r : REAL := 5.0; t : TIME := T#1s5ms; s : STRING := 'ab';");
  const TestResult result = run(
      "ASSERT_TRUE(a = 4); ASSERT_FALSE(a = 5); ASSERT_EQ(4, a); ASSERT_NE(5, a); ASSERT_LT(5, a); ASSERT_LE(4, a);"
      "ASSERT_GT(5, a); ASSERT_GE(6, a); ASSERT_NEAR(4.0, r, 0.2); ASSERT_NEAR(T#2s, t, T#10ms); ASSERT_EQ('b', s);",
      "a : INT := 5; r : REAL := 5.0; t : TIME := T#1s5ms; s : STRING := 'ab';");
  EXPECT_EQ(result.failure_count, 11u) << shown(result);
  EXPECT_EQ(result.failures[9].expected, "T#2s +- T#10ms");
  EXPECT_EQ(result.failures[9].got, "T#1s5ms");
}

TEST(Runner, InputsAreWrittenByAddressGlobalAndPath) {
  expect_passes("%IX0.0 := TRUE; RUN_CYCLES(1); ASSERT_TRUE(%QX0.0); ASSERT_TRUE(main.Lamp);");
  expect_passes("main.Start := TRUE; RUN_CYCLES(1); ASSERT_TRUE(Main.Lamp);");
  expect_passes("Level := 21; RUN_CYCLES(1); ASSERT_EQ(42, main.List[2]);");
}

TEST(Runner, LocalsOfInstancesAreReadAndWritten) {
  expect_passes("main.Start := TRUE; RUN_CYCLES(3); ASSERT_EQ(1, main.first.Starts);");
  expect_passes("main.first.Starts := 10; main.Start := TRUE; RUN_CYCLES(1); ASSERT_EQ(11, main.first.Starts);");
  expect_passes("main.List[3] := 9; RUN_CYCLES(1); ASSERT_EQ(9, main.List[3]);");
  expect_passes("i := 3; main.List[i] := 8; RUN_CYCLES(1); ASSERT_EQ(8, main.List[i]);", "i : INT;");
}

TEST(Runner, LoopsGoAroundCyclesAndTime) {
  expect_passes(
      "FOR i := 1 TO 10 DO RUN_CYCLES(1); ASSERT_EQ(i, Count); END_FOR;"
      "WHILE Count < 20 DO ADVANCE_TIME(T#20ms); END_WHILE; ASSERT_EQ(20, Count);"
      "IF Count = 20 THEN RUN_CYCLES(2); END_IF; ASSERT_EQ(22, Count);",
      "i : INT;");
}

TEST(Runner, CyclesAndTimeAreTwoWaysToSayTheSame) {
  expect_passes("RUN_CYCLES(5); ASSERT_EQ(5, Count); ADVANCE_TIME(T#100ms); ASSERT_EQ(10, Count);");
  expect_passes(
      "ADVANCE_TIME(T#30ms); ASSERT_EQ(2, Count); ADVANCE_TIME(T#10ms); ASSERT_EQ(2, Count);"
      "ADVANCE_TIME(T#1ms); ASSERT_EQ(3, Count);");
  expect_passes(
      "main.Start := TRUE; ADVANCE_TIME(T#100ms); ASSERT_FALSE(main.timer.Q); RUN_CYCLES(); "
      "ASSERT_TRUE(main.timer.Q);");
}

TEST(Runner, AValueWrittenTwiceIsSeenEachTime) {
  expect_passes(
      "main.Start := TRUE; RUN_CYCLES(1); main.Start := FALSE; RUN_CYCLES(1); main.Start := TRUE; RUN_CYCLES(1);"
      "ASSERT_EQ(2, main.first.Starts);");
}

TEST(Runner, BlocksOfTheTestSeeItsTime) {
  expect_passes(
      "t(IN := TRUE, PT := T#1s); ADVANCE_TIME(T#999ms); t(); ASSERT_FALSE(t.Q); ADVANCE_TIME(T#1ms); t(); "
      "ASSERT_TRUE(t.Q);",
      "t : TON;");
  expect_passes("p(Go := TRUE); ASSERT_TRUE(p.Running); ASSERT_EQ(1, p.Starts);", "p : Pump;");
}

TEST(Runner, EachTestBeginsFromACold) {
  Project project(
      with_test("Level := 5; RUN_CYCLES(7); main.first.Starts := 3; ASSERT_EQ(7, Count);") +
      "TEST 'then' ASSERT_EQ(0, Count); ASSERT_EQ(0, Level); RUN_CYCLES(1); ASSERT_EQ(1, Count); ASSERT_EQ(0, "
      "main.first.Starts); END_TEST");
  EXPECT_TRUE(project.run(0).passed());
  const TestResult second = project.run(1);
  EXPECT_TRUE(second.passed()) << shown(second);
  EXPECT_TRUE(project.run(0).passed()) << "again";
}

TEST(Runner, AMockedOutputKeepsItsValueUntilUnmocked) {
  expect_passes(
      "MOCK(main.first.Running, TRUE); RUN_CYCLES(2); ASSERT_TRUE(main.Lamp); ASSERT_TRUE(main.first.Running);"
      "MOCK(main.first.Running, FALSE); main.Start := TRUE; RUN_CYCLES(1); ASSERT_FALSE(main.Lamp);"
      "UNMOCK(main.first.Running); RUN_CYCLES(1); ASSERT_TRUE(main.Lamp); ASSERT_EQ(1, main.first.Starts);");
  expect_passes("MOCK(main.timer.ET, T#7s); RUN_CYCLES(1); ASSERT_EQ(T#7s, main.timer.ET);");
  expect_passes("MOCK(p.Running, TRUE); p(); ASSERT_TRUE(p.Running);", "p : Pump;");
}

TEST(Runner, AFaultOfATaskFailsTheTest) {
  Project project(R"(
PROGRAM Main
VAR x : INT; END_VAR
  WHILE x = 1 DO ; END_WHILE;
END_PROGRAM
CONFIGURATION C RESOURCE R ON PLC TASK T(INTERVAL := T#20ms, PRIORITY := 0); PROGRAM main WITH T : Main; END_RESOURCE END_CONFIGURATION
TEST 'it' RUN_CYCLES(1); main.x := 1; RUN_CYCLES(1); END_TEST)");
  const TestResult result = project.run();
  ASSERT_EQ(result.failure_count, 1u);
  EXPECT_NE(result.failures[0].what.find("R1001"), std::string::npos) << result.failures[0].what;
  EXPECT_EQ(result.failures[0].line, 4u);
}

TEST(Runner, EndlessTestsEnd) {
  const TestResult loop = run("WHILE TRUE DO i := i + 1; END_WHILE;", "i : DINT;");
  ASSERT_EQ(loop.failure_count, 1u);
  EXPECT_NE(loop.failures[0].what.find("R1001"), std::string::npos);
  const TestResult time = run("ADVANCE_TIME(T#10000d);");
  ASSERT_EQ(time.failure_count, 1u);
  EXPECT_NE(time.failures[0].what.find("--max-cycles"), std::string::npos);
  EXPECT_EQ(time.failures[0].at_ns, 99'999 * core::TimeNs{20'000'000}) << "of the last cycle, not of the call";
}

TEST(Runner, TimeDoesNotGoBack) {
  EXPECT_EQ(run("ADVANCE_TIME(T#-5s);").failure_count, 1u);
  EXPECT_EQ(run("RUN_CYCLES(-1);").failure_count, 1u);
  EXPECT_EQ(run("ADVANCE_TIME(T#0s); RUN_CYCLES(0);").failure_count, 0u);
}

TEST(Runner, FailuresBeyondTheFirstAreCounted) {
  const TestResult result = run("FOR i := 1 TO 1000 DO ASSERT_TRUE(FALSE); END_FOR;", "i : INT;");
  EXPECT_EQ(result.failure_count, 1000u);
  EXPECT_EQ(result.failures.size(), kMaxFailuresKept);
}

TEST(Runner, WrongCallsAreNamed) {
  EXPECT_NE(Project(with_test("ASSERT_EQ(1);")).messages().find("P7901"), std::string::npos);
  EXPECT_NE(Project(with_test("ASSERT_EQ(main.List, main.List);")).messages().find("P7901"), std::string::npos);
  EXPECT_NE(Project(with_test("ASSERT_TRUE(x := TRUE);")).messages().find("P7901"), std::string::npos);
  EXPECT_NE(Project(with_test("%IX9.0 := TRUE;")).messages().find("P7902"), std::string::npos);
  EXPECT_NE(Project(with_test("MOCK(main.Lamp, TRUE);")).messages().find("P7905"), std::string::npos);
  EXPECT_NE(Project("TEST 'it' RUN_CYCLES(1); END_TEST").messages().find("P7903"), std::string::npos);
  EXPECT_NE(Project(with_test("ASSERT_TRUE(TRUE);") + "TEST 'it' END_TEST").messages().find("P4018"),
            std::string::npos);
}

TEST(Coverage, BranchesOfIfAndCaseAreSeen) {
  Project project(R"(
PROGRAM Main
VAR x, y : INT; END_VAR
  IF x = 1 THEN y := 1; ELSIF x = 2 THEN y := 2; END_IF;
  CASE x OF 1: y := 3; 2, 3: y := 4; ELSE y := 5; END_CASE;
END_PROGRAM
CONFIGURATION C RESOURCE R ON PLC TASK T(INTERVAL := T#20ms, PRIORITY := 0); PROGRAM main WITH T : Main; END_RESOURCE END_CONFIGURATION
{not_covered Main 'ELSIF x = 2' 'nobody writes 2'}
TEST 'one' RUN_CYCLES(1); ASSERT_EQ(5, main.y); main.x := 1; RUN_CYCLES(1); ASSERT_EQ(3, main.y); END_TEST)",
                  true);
  EXPECT_TRUE(project.run().passed());
  const CoverageReport report = project.coverage();
  ASSERT_EQ(report.pous().size(), 1u);
  const auto& branches = report.pous()[0].by_kind[static_cast<std::size_t>(ir::CoverKind::kBranch)];
  EXPECT_EQ(branches.of, 6u);
  EXPECT_EQ(branches.seen, 4u);
  ASSERT_EQ(report.unseen().size(), 2u);
  EXPECT_EQ(report.unseen()[0].reason, "nobody writes 2");
  EXPECT_EQ(report.sites()[report.unseen()[1].site].text, "CASE 2");
  EXPECT_TRUE(report.idle_waivers().empty());
}

TEST(Coverage, WhatATestCallsItselfCounts) {
  Project project(R"(
FUNCTION Sign : INT
VAR_INPUT x : INT; END_VAR
  IF x < 0 THEN Sign := -1; ELSE Sign := 1; END_IF;
END_FUNCTION
TEST 'both' ASSERT_EQ(-1, Sign(-5)); ASSERT_EQ(1, Sign(5)); END_TEST)",
                  true);
  EXPECT_TRUE(project.run().passed());
  EXPECT_TRUE(project.coverage().unseen().empty());
}

}  // namespace
}  // namespace plc::tests
