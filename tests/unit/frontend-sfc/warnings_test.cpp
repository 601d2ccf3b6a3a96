// What is warned of in charts that compile, and what is not.
#include <gtest/gtest.h>

#include <string>

#include "tests/unit/frontend-sfc/compiled_chart.h"

namespace {

using plc::core::Code;
using plc::test::CompiledChart;

std::string program(const std::string& body, const std::string& variables = "go : BOOL;") {
  return "PROGRAM Logic\nVAR " + variables + " END_VAR\n" + body +
         "END_PROGRAM\nCONFIGURATION c\nRESOURCE r ON PLC\nTASK t(INTERVAL := T#10ms, PRIORITY := 0);\n"
         "PROGRAM main WITH t : Logic;\nEND_RESOURCE\nEND_CONFIGURATION\n";
}
std::string steps(int count) {
  std::string text = "INITIAL_STEP S0: END_STEP\n";
  for (int i = 1; i < count; ++i) text += "STEP S" + std::to_string(i) + ": END_STEP\n";
  return text;
}
std::string transition(const std::string& from, const std::string& to) {
  return "TRANSITION FROM " + from + " TO " + to + " := go; END_TRANSITION\n";
}

TEST(ChartWarnings, NoneForSplitAndJoin) {
  const CompiledChart chart(
      program(steps(4) + transition("S0", "(S1, S2)") + transition("(S1, S2)", "S3") + transition("S3", "S0")));
  EXPECT_NE(chart.simulation, nullptr) << chart.errors();
  EXPECT_TRUE(chart.diagnostics.all().empty());
}

TEST(ChartWarnings, AStepThatNothingLeadsTo) {
  const CompiledChart chart(program(steps(3) + transition("S0", "S1") + transition("S1", "S0")));
  EXPECT_EQ(chart.count(Code::P3114), 1u);
  EXPECT_EQ(chart.diagnostics.all().size(), 1u);
}

TEST(ChartWarnings, AJoinOfAChoiceNeverClears) {
  const CompiledChart chart(
      program(steps(3) + transition("S0", "S1") + transition("S0", "S2") + transition("(S1, S2)", "S0")));
  EXPECT_EQ(chart.count(Code::P3117), 1u);
  EXPECT_EQ(chart.count(Code::P3116), 0u);
}

TEST(ChartWarnings, BranchesLedTogetherByAChoice) {
  const CompiledChart chart(
      program(steps(4) + transition("S0", "(S1, S2)") + transition("S1", "S3") + transition("S2", "S3")));
  EXPECT_EQ(chart.count(Code::P3116), 1u);
}

TEST(ChartWarnings, TheExplorationGivesUpAndSaysSo) {
  std::string body = "INITIAL_STEP Begin: END_STEP\n", all;
  for (int i = 0; i < 16; ++i) {
    const std::string n = std::to_string(i);
    body += "STEP A" + n + ": END_STEP\nSTEP B" + n + ": END_STEP\n" + transition("A" + n, "B" + n);
    all += (i == 0 ? "A" : ", A") + n;
  }
  const CompiledChart chart(program(body + transition("Begin", "(" + all + ")")));
  EXPECT_EQ(chart.count(Code::P3119), 1u);
  EXPECT_NE(chart.simulation, nullptr) << chart.errors();
}

TEST(ChartWarnings, AnErrorInAChartDrawsNoWarningsOfIt) {
  const CompiledChart chart(program(steps(2) + transition("S0", "S9") + transition("S1", "S0")));
  EXPECT_EQ(chart.count(Code::P3104), 1u);
  EXPECT_EQ(chart.count(Code::P3114), 0u);
}

TEST(ChartWarnings, AStepIsOnlyRead) {
  const CompiledChart chart(program("INITIAL_STEP S0: Write(N); END_STEP\n" + transition("S0", "S0") +
                                        "ACTION Write: S0.X := TRUE; t := s0.t; END_ACTION\n",
                                    "go : BOOL; t : TIME;"));
  EXPECT_EQ(chart.count(Code::P4007), 1u);
  EXPECT_EQ(chart.diagnostics.error_count(), 1u) << chart.errors();
}

}  // namespace
