// Lints of charts: what they report, and what looks alike and is right.
#include "ir/lint.h"

#include <gtest/gtest.h>

#include <string>

#include "compiler/lower_project.h"
#include "declare/declare.h"
#include "frontend-st/read.h"
#include "ir/check.h"

namespace {

using namespace plc;

/// The findings as "POU:line", separated by blanks; or the errors.
std::string lint(const std::string& name, const std::string& text, const core::CompileOptions& compile = {}) {
  core::Diagnostics diagnostics;
  const auto project = st::read_memory(text, "chart.st", diagnostics);
  const auto module = st::declare(*project, compile, diagnostics);
  compiler::lower_project(*project, *module, false, false, diagnostics);
  const ir::LintOptions options = ir::LintOptions().with("none," + name).value();
  ir::mute_others(options, diagnostics);
  const std::size_t before = diagnostics.all().size();
  if (ir::check(*module, diagnostics) && !diagnostics.has_errors()) ir::lint(*module, options, diagnostics);
  std::string found;
  for (std::size_t i = 0; i < diagnostics.all().size(); ++i) {
    const core::Diagnostic& one = diagnostics.all()[i];
    if (one.severity == core::Severity::kError) return diagnostics.render_one(one);
    if (i >= before) found += (found.empty() ? "" : " ") + one.pou + ":" + std::to_string(one.at.line);
  }
  return found;
}

/// Main with two steps, the second of which has `actions`; their bodies begin in line 10.
std::string chart(const std::string& variables, const std::string& actions, const std::string& bodies,
                  const std::string& others = "") {
  return "PROGRAM Main\nVAR go, v : BOOL; " + variables + " END_VAR\nINITIAL_STEP A:\nEND_STEP\nSTEP B: " + actions +
         "\nEND_STEP\nTRANSITION FROM A TO B := go; END_TRANSITION\nTRANSITION FROM B TO A := NOT go; "
         "END_TRANSITION\n" +
         "\n" + bodies + "\nEND_PROGRAM\n" + others +
         "CONFIGURATION c\nRESOURCE r ON PLC\nTASK t(INTERVAL := T#10ms, PRIORITY := 0);\n"
         "PROGRAM main WITH t : Main;\nEND_RESOURCE\nEND_CONFIGURATION\n";
}

TEST(ChartVariable, AWriteInAnActionOfTheChart) {
  EXPECT_EQ(lint("chart-variable", chart("", "v(N); Stop(N);", "ACTION Stop: v := FALSE; END_ACTION")), "Main.Stop:10");
  EXPECT_EQ(lint("chart-variable", chart("", "v(S); Look(N);", "ACTION Look: go := v; END_ACTION")), "");
}

TEST(ChartVariable, StepsAndQualifiersOfOneChartAreNoOthers) {
  EXPECT_EQ(lint("chart-variable", chart("", "v(S); v(R); go(N);", "")), "");
}

TEST(ChartVariable, AnotherPouAndTheChartOfAnother) {
  const std::string globals = "VAR_GLOBAL motor : BOOL; END_VAR\n";
  const std::string writer =
      "FUNCTION_BLOCK Writer\nVAR_EXTERNAL motor : BOOL; END_VAR\n  motor := TRUE;\n"
      "END_FUNCTION_BLOCK\n";
  const std::string drives = chart("w : Writer; END_VAR VAR_EXTERNAL motor : BOOL;", "motor(N); Run(N);",
                                   "ACTION Run: w(); END_ACTION", writer + globals);
  EXPECT_EQ(lint("chart-variable", drives), "Writer:14");
  const std::string second =
      "FUNCTION_BLOCK Other\nVAR_EXTERNAL motor : BOOL; END_VAR\nINITIAL_STEP S: motor(N); END_STEP\n"
      "TRANSITION FROM S TO S := TRUE; END_TRANSITION\nEND_FUNCTION_BLOCK\n";
  EXPECT_EQ(lint("chart-variable", chart("w : Other; END_VAR VAR_EXTERNAL motor : BOOL;", "motor(N); Run(N);",
                                         "ACTION Run: w(); END_ACTION", second + globals)),
            "Other:14");
}

TEST(ChartVariable, PartsOfStructuresAreToldApart) {
  const std::string type = "TYPE Valve : STRUCT open, seen : BOOL; END_STRUCT END_TYPE\n";
  EXPECT_EQ(lint("chart-variable", chart("p, q : Valve;", "p.open(N); Note(N);",
                                         "ACTION Note: p.seen := TRUE; q.open := TRUE; END_ACTION", type)),
            "");
  EXPECT_EQ(lint("chart-variable",
                 chart("p : Valve;", "p.open(N); Note(N);", "ACTION Note:\np.open := TRUE; END_ACTION", type)),
            "Main.Note:11");
}

TEST(ActionTimer, FreezesWithoutAFinalScan) {
  const std::string text = chart("t : TON;", "Wait(N);", "ACTION Wait: t(IN := B.X, PT := T#1s); v := t.Q; END_ACTION");
  EXPECT_EQ(lint("action-timer", text), "Main.Wait:10");
  core::CompileOptions options;
  options.sfc_final_scan = core::FinalScan::kOn;
  EXPECT_EQ(lint("action-timer", text, options), "");
}

TEST(ActionTimer, IsRightWhereSomethingElseRunsOrRearmsIt) {
  EXPECT_EQ(lint("action-timer", chart("t : TON;", "Wait(N); Ready(P0);",
                                       "ACTION Wait: t(IN := TRUE, PT := T#1s); END_ACTION\n"
                                       "ACTION Ready: t(IN := FALSE); END_ACTION")),
            "");
  EXPECT_EQ(lint("action-timer", chart("t : TON;", "Wait(N); Both(N);",
                                       "ACTION Wait: t(IN := go, PT := T#1s); END_ACTION\n"
                                       "ACTION Both: t(IN := v); END_ACTION")),
            "");
  EXPECT_EQ(lint("action-timer", chart("c : CTU;", "Count(N);", "ACTION Count: c(CU := go, PV := 3); END_ACTION")), "");
}

}  // namespace
