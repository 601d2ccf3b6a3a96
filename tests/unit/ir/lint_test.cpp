// Every lint with what it reports and what it leaves alone: from ST, and from drawings where those differ.
#include "ir/lint.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/unit/ir/linted.h"

namespace plc {
namespace {

using core::ElementKind;
using ir::Lint;
using test::add_coil;
using test::BodyBuilder;
using test::ladder;
using test::lint;
using test::lint_statements;
using test::Linted;
using test::program;

// ---- rows and switches --------------------------------------------------------------------------------------------

TEST(LintOptions, EveryRowHasAWarningOrNoteOfItsOwn) {
  std::vector<core::Code> codes;
  for (const ir::LintInfo& row : ir::lints()) {
    EXPECT_NE(core::info(row.code).severity, core::Severity::kError) << row.name;
    EXPECT_EQ(std::count(codes.begin(), codes.end(), row.code), 0) << row.name;
    codes.push_back(row.code);
  }
}

TEST(LintOptions, AreAppliedFromLeftToRightToTheDefaults) {
  const ir::LintOptions usual;
  EXPECT_TRUE(usual.on(Lint::kUnusedVariable));
  EXPECT_FALSE(usual.on(Lint::kOneWayGlobal));
  const auto one = usual.with("none,double-coil");
  EXPECT_TRUE(one.value().on(Lint::kDoubleCoil));
  EXPECT_FALSE(one.value().on(Lint::kUnusedVariable));
  const auto fewer = usual.with("-unused-variable, One-Way-Global");
  EXPECT_FALSE(fewer.value().on(Lint::kUnusedVariable));
  EXPECT_TRUE(fewer.value().on(Lint::kOneWayGlobal));
  EXPECT_TRUE(fewer.value().on(Lint::kDoubleCoil));
  EXPECT_FALSE(usual.with("all,-P4301").value().on(Lint::kUnusedVariable));
}

TEST(LintOptions, UnknownNamesAreGuessed) {
  const auto wrong = ir::LintOptions().with("none,double-coils");
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().message.find("\"double-coils\""), std::string::npos) << wrong.error().message;
  EXPECT_NE(wrong.error().help.find("double-coil"), std::string::npos) << wrong.error().help;
  EXPECT_FALSE(ir::LintOptions().with("-all"));
}

// ---- declarations -------------------------------------------------------------------------------------------------

TEST(Lint, UnusedVariables) {
  EXPECT_EQ(lint_statements("unused-variable", "a : INT;\nb : INT;\nt : TON;", "a := a + 1;"), "Main:3 Main:4");
  EXPECT_EQ(lint("none,unused-variable",
                 "FUNCTION_BLOCK F\nVAR_INPUT\n A : INT;\n B : INT; END_VAR\nVAR_IN_OUT\n C : INT; END_VAR\n"
                 "VAR_OUTPUT Q : INT; END_VAR\nQ := A; END_FUNCTION_BLOCK"),
            "F:4 F:6");
}

TEST(Lint, VariablesUsedFromOutsideOrByDeclarationsAreNotUnused) {
  EXPECT_EQ(lint_statements("unused-variable", "In AT %IX0.0 : BOOL;\nOut AT %QX0.0 : BOOL;\na : INT;", "a := a + 1;"),
            "");
  EXPECT_EQ(lint("none,unused-variable",
                 "PROGRAM Main VAR CONSTANT\n Top : INT := 4; END_VAR VAR List : ARRAY [0..Top] OF INT; END_VAR\n"
                 "List[0] := 1; END_PROGRAM"),
            "");
}

TEST(Lint, PartsAndHandlesCountAsUse) {
  EXPECT_EQ(lint("none,unused-variable,never-written,never-read",
                 "TYPE S : STRUCT x, y : INT; END_STRUCT END_TYPE\n"
                 "FUNCTION_BLOCK F VAR_IN_OUT C : INT; END_VAR C := C + 1; END_FUNCTION_BLOCK\n"
                 "FUNCTION_BLOCK G VAR f1 : F; n : INT; s : S; list : ARRAY [1..3] OF INT; i : INT := 1; END_VAR\n"
                 "VAR_OUTPUT Q : INT; END_VAR\n"
                 "f1(C := n); s.x := 1; list[i] := s.y; Q := list[2]; END_FUNCTION_BLOCK"),
            "");
}

TEST(Lint, ExternalVariablesAndGlobals) {
  const std::string configuration =
      "CONFIGURATION C\nVAR_GLOBAL\n g : INT;\n h : INT;\n END_VAR RESOURCE R ON PLC TASK T(INTERVAL := T#10ms, "
      "PRIORITY := 0);\n"
      "PROGRAM m WITH T : Main; END_RESOURCE END_CONFIGURATION\n";
  EXPECT_EQ(
      lint("none,unused-variable",
           configuration + "PROGRAM Main VAR_EXTERNAL g : INT; END_VAR VAR n : INT; END_VAR n := g + n; END_PROGRAM"),
      ":4");
  EXPECT_EQ(lint("none,unused-variable",
                 configuration + "PROGRAM Main VAR_EXTERNAL\n g : INT;\n h : INT; END_VAR g := g + 1; END_PROGRAM\n"
                                 "FUNCTION_BLOCK F VAR_EXTERNAL h : INT; END_VAR h := 1; END_FUNCTION_BLOCK"),
            "Main:9");
  EXPECT_EQ(
      lint("none,one-way-global", configuration + "PROGRAM Main VAR_EXTERNAL g, h : INT; END_VAR g := h; END_PROGRAM"),
      ":3 :4");
  EXPECT_EQ(lint("none,one-way-global",
                 configuration + "PROGRAM Main VAR_EXTERNAL g, h : INT; END_VAR g := h; h := g; END_PROGRAM"),
            "");
}

TEST(Lint, ConnectionsOfProgramsAndVarConfigCountAsUse) {
  EXPECT_EQ(lint("none,unused-variable,never-written,one-way-global",
                 "PROGRAM Main VAR_INPUT A : INT; END_VAR VAR_OUTPUT B : INT; END_VAR VAR n : INT; END_VAR\n"
                 "B := A + n; END_PROGRAM\n"
                 "CONFIGURATION C VAR_GLOBAL g, h : INT; END_VAR RESOURCE R ON PLC TASK T(INTERVAL := T#10ms, PRIORITY "
                 ":= 0);\n"
                 "PROGRAM m WITH T : Main(A := g, B => h); PROGRAM n WITH T : Main(A := h, B => g); END_RESOURCE\n"
                 "VAR_CONFIG R.m.n : INT := 3; END_VAR END_CONFIGURATION"),
            "");
}

TEST(Lint, NeverWritten) {
  EXPECT_EQ(lint_statements("never-written", "a : INT;\nb : INT;\nc : INT := 0;", "b := a + c;"), "Main:2");
  EXPECT_EQ(lint("none,never-written",
                 "FUNCTION F : INT\nVAR_INPUT A : INT; END_VAR\nVAR_OUTPUT\n Q : INT; END_VAR\n"
                 "VAR n : INT; END_VAR\nn := A; END_FUNCTION"),
            "F:1 F:4");
  EXPECT_EQ(lint("none,never-written",
                 "PROGRAM Main VAR RETAIN\n kept : INT; END_VAR VAR Q AT %QW0 : INT; I AT %IW0 : INT; END_VAR\n"
                 "Q := kept + I; END_PROGRAM"),
            "");
}

TEST(Lint, NeverRead) {
  const std::string body = "VAR_INPUT A : INT; END_VAR VAR\n n : INT; END_VAR\n n := A; ";
  EXPECT_EQ(lint("none,never-read", "FUNCTION F : INT\n" + body + "F := A; END_FUNCTION"), "F:3");
  EXPECT_EQ(lint("none,never-read", "FUNCTION_BLOCK F\n" + body + "END_FUNCTION_BLOCK"), "F:3");
  EXPECT_EQ(lint("none,never-read", "PROGRAM F\n" + body + "END_PROGRAM"), "") << "an HMI may read it";
  EXPECT_EQ(lint("none,never-read", "PROGRAM F VAR_TEMP\n n : INT; END_VAR n := 1; END_PROGRAM"), "F:2");
}

TEST(Lint, InstancesThatAreNeverCalled) {
  const std::string declarations = "t : TON;\nq : BOOL;";
  EXPECT_EQ(lint_statements("block-never-called", declarations, "t.IN := TRUE; q := t.Q;"), "Main:2");
  EXPECT_EQ(lint_statements("block-never-called", declarations, "t(IN := TRUE); q := t.Q;"), "");
  EXPECT_EQ(lint_statements("block-never-called", "t : ARRAY [1..3] OF TON;\ni : INT := 1;\nq : BOOL;",
                            "t[i](IN := TRUE); q := t[1].Q;"),
            "");
}

TEST(Lint, PousThatNothingUses) {
  const std::string rest =
      "FUNCTION F : INT F := 1; END_FUNCTION\nFUNCTION G : INT G := 1; END_FUNCTION\n"
      "FUNCTION_BLOCK B VAR_OUTPUT Q : INT; END_VAR Q := G(); END_FUNCTION_BLOCK\n"
      "PROGRAM Main VAR list : ARRAY [1..2] OF B; n : INT; END_VAR n := list[1].Q; END_PROGRAM\n"
      "PROGRAM Spare VAR n : INT; END_VAR n := 1; END_PROGRAM\n";
  const std::string configuration =
      "CONFIGURATION C RESOURCE R ON PLC TASK T(INTERVAL := T#10ms, PRIORITY := 0);\n"
      "PROGRAM m WITH T : Main; END_RESOURCE END_CONFIGURATION\n";
  EXPECT_EQ(lint("none,unused-pou", rest + configuration), "F:1 Spare:5");
  EXPECT_EQ(lint("none,unused-pou", rest), "") << "a file without a task is a library";
}

TEST(Lint, ActionsUseTheVariablesOfTheirPou) {
  const std::string text =
      "FUNCTION_BLOCK B VAR\n a : INT;\n b : INT;\n t : TON; END_VAR\n"
      "t(IN := TRUE); END_FUNCTION_BLOCK\n"
      "ACTION Run: a := a + 1; t.PT := T#1s; END_ACTION\n"
      "PROGRAM Main VAR n : INT; END_VAR n := 1; END_PROGRAM ACTION Idle: END_ACTION\n";
  EXPECT_EQ(lint("none,unused-variable,never-written,never-read,missing-preset", text), "B:3");
  const std::string loop =
      "PROGRAM P VAR i : INT; END_VAR END_PROGRAM\n"
      "ACTION A:\n FOR i := 1 TO 3 DO\n i := i + 1; END_FOR END_ACTION\n";
  EXPECT_EQ(lint("none,loop-variable", loop), "P.A:4");
}

TEST(Lint, ProgramsByName) {
  const std::string programs =
      "PROGRAM Run VAR_OUTPUT q : INT; END_VAR q := 1; END_PROGRAM\n"
      "PROGRAM Called VAR n : INT; END_VAR n := 1; END_PROGRAM\n"
      "PROGRAM Seen VAR n : INT; END_VAR n := 1; END_PROGRAM\n"
      "PROGRAM Main VAR n : INT; END_VAR\n Called();\n n := Seen.n + Run.q;\n";
  const std::string rest =
      " END_PROGRAM\nCONFIGURATION C RESOURCE R ON PLC TASK T(INTERVAL := T#10ms, PRIORITY := 0);\n"
      "PROGRAM r WITH T : Run; PROGRAM m WITH T : Main; END_RESOURCE END_CONFIGURATION\n";
  EXPECT_EQ(lint("none,unused-pou,program-twice,foreign-output,two-task-writes", programs + rest), "Seen:3");
  EXPECT_EQ(lint("none,program-twice", programs + "\n Run();" + rest), "Main:8");
}

TEST(Lint, ShadowedNames) {
  const std::string text =
      "TYPE Mode : (Idle, Busy); END_TYPE\n"
      "FUNCTION Scale : INT Scale := 1; END_FUNCTION\n"
      "FUNCTION_BLOCK Pump VAR_INPUT Level : INT; END_VAR END_FUNCTION_BLOCK\n"
      "PROGRAM Main VAR\n Level : INT;\n Scale : INT;\n Busy : BOOL;\n Pump : Pump;\n Limit : INT;\n END_VAR\n"
      "Level := Scale; END_PROGRAM\n"
      "CONFIGURATION C VAR_GLOBAL Level : INT; END_VAR RESOURCE R ON PLC TASK T(INTERVAL := T#10ms, PRIORITY := 0);\n"
      "PROGRAM m WITH T : Main; END_RESOURCE END_CONFIGURATION\n";
  EXPECT_EQ(lint("none,shadowed-name", text), "Main:5 Main:6 Main:7");
}

// ---- expressions --------------------------------------------------------------------------------------------------

TEST(Lint, RealEquality) {
  const std::string declarations = "a, b, old : REAL;\nc : LREAL;\nq : BOOL;\nn : INT;";
  EXPECT_EQ(lint_statements("real-equality", declarations, "q := a = b;\nq := c <> 1.5;\nq := n = 3;"),
            "Main:11 Main:12");
  EXPECT_EQ(lint_statements("real-equality", declarations, "q := a <> 0.0;\nq := a <> a;\nq := ABS(a - b) < 0.1;"), "");
  EXPECT_EQ(lint_statements("real-equality", declarations, "q := a <> old;\nold := a;"), "")
      << "whether it changed is exact";
}

TEST(Lint, ProductsInANarrowType) {
  const std::string declarations = "a, b : INT;\nd : DINT;\nr : REAL;\ns, t : SINT;\np : INT (0..100);";
  EXPECT_EQ(lint_statements("narrow-product", declarations, "d := a * b;\nr := a * b;\nd := INT_TO_DINT(a * b);"),
            "Main:11 Main:12 Main:13");
  EXPECT_EQ(
      lint_statements("narrow-product", declarations,
                      "d := INT_TO_DINT(a) * b;\na := a * b;\nd := a + b;\nd := SINT_TO_INT(s) * SINT_TO_INT(t);\n"
                      "d := p * 10;\ns := INT_TO_SINT(a * b);"),
      "");
}

TEST(Lint, IntegerDivisionUsedAsReal) {
  const std::string declarations = "a, b : INT;\nd : DINT;\nr : REAL;";
  EXPECT_EQ(lint_statements("integer-division", declarations, "r := a / b;\nr := INT_TO_REAL(a / 2);"),
            "Main:11 Main:12");
  EXPECT_EQ(lint_statements("integer-division", declarations,
                            "r := INT_TO_REAL(a) / INT_TO_REAL(b);\nd := a / b;\nr := a MOD b;"),
            "");
}

TEST(Lint, ComparisonsThatTheTypeDecides) {
  const std::string declarations = "u : UINT;\ni : INT;\nq : BOOL;\nb : USINT;";
  EXPECT_EQ(lint_statements("constant-comparison", declarations,
                            "q := u >= 0;\nq := u < 0;\nq := i <= 32767;\nq := 0 > u;\nq := i = i;\nq := b > 255;"),
            "Main:11 Main:12 Main:13 Main:14 Main:15 Main:16");
  EXPECT_EQ(lint_statements(
                "constant-comparison", declarations,
                "q := u > 0;\nq := i < 32767;\nq := u = 0;\nq := 0 < u;\nq := UINT_TO_INT(u) < 0;\nq := b >= 255;"),
            "");
}

TEST(Lint, ComparisonsThatLoopsAndLabelsImplyAreNotReported) {
  EXPECT_EQ(
      lint_statements("constant-comparison", "b : USINT;\nn : INT;",
                      "FOR b := 0 TO 255 DO n := n + 1; END_FOR;\nCASE b OF 0..5: n := 1; 6..255: n := 2; END_CASE;"),
      "");
}

TEST(Lint, DivisionByZero) {
  const std::string declarations = "a : INT;\nr : REAL;";
  EXPECT_EQ(lint_statements("division-by-zero", declarations, "a := a / 0;\na := a MOD 0;\nr := r / 0.0;"),
            "Main:11 Main:12 Main:13");
  EXPECT_EQ(lint_statements("division-by-zero", declarations, "a := a / 2;\na := 0 / a;"), "");
}

// ---- statements ---------------------------------------------------------------------------------------------------

TEST(Lint, CodeThatIsNeverReached) {
  const std::string declarations = "a, i : INT;\nq : BOOL;\nt : TON;";
  EXPECT_EQ(lint_statements("unreachable", declarations, "IF q THEN RETURN;\na := 1; END_IF;\na := 2;"), "Main:12");
  EXPECT_EQ(lint_statements("unreachable", declarations, "IF FALSE AND q THEN\na := 1;\na := 2; END_IF;"), "Main:12");
  EXPECT_EQ(lint_statements("unreachable", declarations, "IF TRUE THEN a := 1; ELSE\na := 2; END_IF;"), "Main:12");
  EXPECT_EQ(lint_statements("unreachable", declarations, "WHILE q DO EXIT;\nt(IN := q); END_WHILE;"), "Main:12");
  EXPECT_EQ(lint_statements("unreachable", declarations, "WHILE TRUE DO a := a + 1; END_WHILE;\na := 2;"), "Main:12");
}

TEST(Lint, WhatLoopsAndBranchesLeaveBehindIsNotUnreachableCode) {
  const std::string declarations = "a, i : INT;\nq : BOOL;";
  EXPECT_EQ(lint_statements("unreachable", declarations,
                            "FOR i := 1 TO 9 DO a := a + i; EXIT; END_FOR;\nIF q THEN RETURN; ELSE a := 1; END_IF;\n"
                            "WHILE TRUE DO IF q THEN EXIT; END_IF; q := TRUE; END_WHILE;\na := 2; RETURN;"),
            "");
}

TEST(Lint, SelfAssignment) {
  const std::string declarations = "a, b : INT;\nlist : ARRAY [1..3] OF INT;";
  EXPECT_EQ(lint_statements("self-assignment", declarations, "a := a;\nlist[2] := list[2];"), "Main:11 Main:12");
  EXPECT_EQ(lint_statements("self-assignment", declarations, "a := b;\nlist[2] := list[1];\na := a + 1;"), "");
}

TEST(Lint, EmptyBranches) {
  const std::string declarations = "a : INT;\nq : BOOL;";
  EXPECT_EQ(lint_statements("empty-branch", declarations, "IF q THEN ; END_IF;\nIF a > 1 THEN END_IF;"),
            "Main:11 Main:12");
  EXPECT_EQ(lint_statements("empty-branch", declarations,
                            "IF q THEN ; ELSE a := 1; END_IF;\nIF q THEN ; ELSIF a > 1 THEN a := 1; END_IF;\n"
                            "CASE a OF 1: a := 2; 2: ; END_CASE;\nWHILE q DO ; END_WHILE;"),
            "");
}

TEST(Lint, CasesOverEnumerations) {
  const std::string before = "TYPE Mode : (Idle, Busy, Done := 7); END_TYPE ";
  const std::string declarations = "m : Mode;\na : INT;\n";
  const auto found = [&](const std::string& text) {
    return lint("none,missing-case", before + program(declarations, text));
  };
  EXPECT_EQ(found("CASE m OF\nIdle: a := 1; Busy: a := 2; END_CASE;"), "Main:12");
  EXPECT_EQ(found("CASE m OF Idle, Busy: a := 1; Done: a := 2; END_CASE;"), "");
  EXPECT_EQ(found("CASE m OF Idle: a := 1; ELSE a := 2; END_CASE;"), "");
  EXPECT_EQ(found("CASE m OF Idle: a := 1; ELSE ; END_CASE;"), "") << "an empty ELSE says that it is meant";
  EXPECT_EQ(found("CASE a OF 1: a := 1; END_CASE;\nIF m = Idle THEN a := 2; END_IF;"), "");
}

TEST(Lint, ControlVariablesWrittenInTheirLoop) {
  const std::string declarations = "i, j, a : INT;\np : INT (0..9);";
  EXPECT_EQ(
      lint_statements("loop-variable", declarations, "FOR i := 1 TO 9 DO\nIF a > 3 THEN i := 9; END_IF; END_FOR;"),
      "Main:12");
  EXPECT_EQ(lint_statements("loop-variable", declarations,
                            "FOR i := 1 TO 9 BY 2 DO\nFOR i := 1 TO 3 DO a := i; END_FOR; END_FOR;"),
            "Main:12");
  EXPECT_EQ(lint_statements("loop-variable", declarations, "FOR p := 0 TO 9 DO\np := 3; END_FOR;"), "Main:12");
  EXPECT_EQ(lint_statements("loop-variable", declarations,
                            "FOR i := 1 TO 9 DO FOR j := i TO 9 BY a DO a := i * j; END_FOR; END_FOR;\ni := 0;\n"
                            "FOR i := 9 TO 1 BY -1 DO a := i; END_FOR;"),
            "");
}

// ---- function block instances -------------------------------------------------------------------------------------

TEST(Lint, BlocksCalledUnderAConditionOnly) {
  const std::string declarations = "q : BOOL;\nt : TON;\nc : CTU;\ne : R_TRIG;\ns : SR;\ni : INT;";
  const auto found = [&](const std::string& text) { return lint_statements("conditional-block", declarations, text); };
  EXPECT_EQ(found("IF q THEN\nt(IN := TRUE); END_IF;"), "Main:12");
  EXPECT_EQ(found("CASE i OF 1:\nc(CU := q); 2:\ne(CLK := q); END_CASE;"), "Main:12 Main:13");
  EXPECT_EQ(found("WHILE q DO\nt(IN := q); END_WHILE;"), "Main:12");
  EXPECT_EQ(found("IF q THEN t(IN := q); ELSIF i > 1 THEN t(IN := NOT q); END_IF;"), "Main:11");
  EXPECT_EQ(found("t(IN := q, EN := q);"), "Main:11");
}

TEST(Lint, BlocksCalledOnEveryWayOrRearmedByHand) {
  const std::string declarations = "q : BOOL;\nt : TON;\ns : SR;\ni : INT;\nlist : ARRAY [1..4] OF TON;";
  const auto found = [&](const std::string& text) { return lint_statements("conditional-block", declarations, text); };
  EXPECT_EQ(found("t(IN := q);"), "");
  EXPECT_EQ(found("IF q THEN t(IN := q); ELSE t(IN := NOT q); END_IF;"), "");
  EXPECT_EQ(found("IF q THEN IF i > 1 THEN t(IN := q); ELSE t(); END_IF; ELSE t(); END_IF;"), "");
  EXPECT_EQ(found("IF q THEN s(S1 := q); END_IF;"), "") << "SR remembers nothing but its output";
  EXPECT_EQ(found("IF q THEN t(IN := TRUE); IF t.Q THEN t(IN := FALSE); END_IF; END_IF;"), "");
  EXPECT_EQ(found("FOR i := 1 TO 4 DO list[i](IN := q); END_FOR;"), "");
  EXPECT_EQ(found("IF q THEN RETURN; END_IF; t(IN := q);"), "") << "the POU is switched off as a whole";
  EXPECT_EQ(found("IF TRUE THEN t(IN := q); END_IF;"), "");
}

TEST(Lint, InstancesCalledTwice) {
  const std::string declarations = "q : BOOL;\ne : R_TRIG;\ni : INT;\nlist : ARRAY [1..4] OF R_TRIG;";
  const auto found = [&](const std::string& text) { return lint_statements("block-twice", declarations, text); };
  EXPECT_EQ(found("e(CLK := q);\ne(CLK := NOT q);"), "Main:12");
  EXPECT_EQ(found("FOR i := 1 TO 4 DO\ne(CLK := q); END_FOR;"), "Main:12");
  EXPECT_EQ(found("list[1](CLK := q);\nlist[1](CLK := NOT q);"), "Main:12");
  EXPECT_EQ(found("IF q THEN e(CLK := q); ELSE e(CLK := NOT q); END_IF;\nlist[1](CLK := q); list[2](CLK := q);"), "");
  EXPECT_EQ(found("FOR i := 1 TO 4 DO list[i](CLK := q); END_FOR;"), "");
}

TEST(Lint, TimersWithoutPreset) {
  const std::string declarations = "q : BOOL;\nt : TON;\nu : TON := (PT := T#3s);\nc : CTU;";
  const auto found = [&](const std::string& text) { return lint_statements("missing-preset", declarations, text); };
  EXPECT_EQ(found("q := q;\nt(IN := q);"), "Main:12");
  EXPECT_EQ(found("t(IN := q, PT := T#1s); u(IN := q); c(CU := q);"), "");
  EXPECT_EQ(found("t.PT := T#1s; t(IN := q);"), "");
}

// ---- drawings -----------------------------------------------------------------------------------------------------

/// A timer `t` whose IN, and EN if `enabled`, are fed by the contact.
void add_timer(BodyBuilder& b, std::int64_t id, bool enabled) {
  plcopen::Element& timer = b.add(ElementKind::kBlock, id, "TON", 100, static_cast<std::int32_t>(id) * 10);
  timer.instance_name = "t";
  if (enabled) BodyBuilder::pin(timer, "EN", {2});
  BodyBuilder::pin(timer, "IN", {2});
}

TEST(LintDrawing, AWiredEnIsACondition) {
  const auto found = [](bool enabled, const std::string& contact) {
    Linted project("PROGRAM Main VAR go : BOOL; t : TON; END_VAR END_PROGRAM");
    project.pou("Main").bodies = {ladder(contact, [&](BodyBuilder& b) { add_timer(b, 3, enabled); })};
    return project.run("none,conditional-block");
  };
  EXPECT_EQ(found(true, "go"), "Main:3");
  EXPECT_EQ(found(false, "go"), "");
  EXPECT_EQ(found(true, "TRUE"), "") << "power from the rail alone";
}

TEST(LintDrawing, AnInstanceDrawnTwice) {
  Linted project("PROGRAM Main VAR go : BOOL; t : TON; END_VAR END_PROGRAM");
  project.pou("Main").bodies = {ladder("go", [](BodyBuilder& b) {
    add_timer(b, 3, false);
    add_timer(b, 4, false);
  })};
  EXPECT_EQ(project.run("none,block-twice"), "Main:4");
}

TEST(LintDrawing, ElementsAfterAReturnAreNotReached) {
  Linted project("PROGRAM Main VAR go, a : BOOL; END_VAR END_PROGRAM");
  project.pou("Main").bodies = {ladder("go", [](BodyBuilder& b) {
    b.add(ElementKind::kReturn, 3, "", 0, 5);
    add_coil(b, 4, "a");
  })};
  project.pou("Main").bodies.front().elements[2].y = -50;
  EXPECT_EQ(project.run("none,unreachable"), "Main:4");
}

TEST(LintDrawing, UnconnectedElementsKeepTheirVariablesFromBeingJudged) {
  Linted project("PROGRAM Main VAR go, a, b : BOOL; END_VAR END_PROGRAM");
  project.pou("Main").bodies = {ladder("go", [](BodyBuilder& b) {
    add_coil(b, 3, "a");
    b.add(ElementKind::kCoil, 4, "b", 200, 80).inputs.emplace_back();
  })};
  EXPECT_EQ(project.run("none,unused-variable,never-written"), "");
}

TEST(LintDrawing, CoilsOfSeveralPousOnOneGlobal) {
  const std::string text =
      "PROGRAM One VAR_EXTERNAL Y : BOOL; END_VAR VAR go : BOOL; END_VAR END_PROGRAM\n"
      "PROGRAM Two VAR_EXTERNAL Y : BOOL; END_VAR VAR go : BOOL; END_VAR END_PROGRAM\n"
      "CONFIGURATION C VAR_GLOBAL Y : BOOL; END_VAR RESOURCE R ON PLC\n"
      "TASK T(INTERVAL := T#10ms, PRIORITY := 0); TASK U(INTERVAL := T#20ms, PRIORITY := 1);\n";
  const std::string one_task = text + "PROGRAM a WITH T : One; PROGRAM b WITH T : Two; END_RESOURCE END_CONFIGURATION";
  const std::string two_tasks = text + "PROGRAM a WITH T : One; PROGRAM b WITH U : Two; END_RESOURCE END_CONFIGURATION";
  const auto found = [](const std::string& source, plcopen::Storage storage, const char* lints) {
    Linted project(source);
    for (const char* name : {"One", "Two"}) {
      project.pou(name).bodies = {ladder("go", [&](BodyBuilder& b) { add_coil(b, 3, "Y").storage = storage; })};
    }
    return project.run(lints);
  };
  EXPECT_EQ(found(one_task, plcopen::Storage::kNone, "none,double-coil"), "Two:3");
  EXPECT_EQ(found(one_task, plcopen::Storage::kSet, "none,double-coil"), "");
  EXPECT_EQ(found(two_tasks, plcopen::Storage::kNone, "none,double-coil"), "") << "that is two-task-writes";
  EXPECT_EQ(found(two_tasks, plcopen::Storage::kNone, "none,two-task-writes"), ":3");
  EXPECT_EQ(found(two_tasks, plcopen::Storage::kNone, "none"), "");
}

// ---- tasks ---------------------------------------------------------------------------------------------------------

/// The finding of rate-monotonic for these tasks as "line message | help", or nothing.
std::string priorities(const std::vector<std::string>& tasks) {
  std::string text =
      "PROGRAM Main VAR x : BOOL; END_VAR x := NOT x; END_PROGRAM\nCONFIGURATION C VAR_GLOBAL e : BOOL; END_VAR "
      "RESOURCE R ON PLC\n";
  for (const std::string& task : tasks) text += "TASK " + task + ";\n";
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    text += "PROGRAM p" + std::to_string(i) + " WITH " + tasks[i].substr(0, tasks[i].find('(')) + " : Main;\n";
  }
  Linted project(text + "END_RESOURCE END_CONFIGURATION");
  const std::string found = project.run("none,rate-monotonic");
  if (project.diagnostics.all().size() != 1) return found;
  const core::Diagnostic& d = project.diagnostics.all().front();
  return std::to_string(d.at.line) + " " + d.message + " | " + d.help;
}

TEST(LintTasks, ASlowTaskMoreUrgentThanAFastOne) {
  EXPECT_EQ(priorities({"Fast(INTERVAL := T#10ms, PRIORITY := 1)", "Slow(INTERVAL := T#100ms, PRIORITY := 0)"}),
            "4 task Fast (every 10ms, priority 1) can wait for whole scans of Slow (every 100ms, priority 0) | "
            "rate-monotonic priorities are Fast 0, Slow 1; or set priorities = \"rate-monotonic\" in [scheduler] of "
            "plc.toml");
}

TEST(LintTasks, AFastTaskWaitsForASlowOneOfItsPriorityToo) {
  EXPECT_EQ(priorities({"Slow(INTERVAL := T#2s, PRIORITY := 3)", "Fast(INTERVAL := T#1500us, PRIORITY := 3)"}),
            "3 task Fast (every 1500us, priority 3) can wait for whole scans of Slow (every 2s, priority 3) | "
            "rate-monotonic priorities are Fast 0, Slow 1; or set priorities = \"rate-monotonic\" in [scheduler] of "
            "plc.toml");
}

TEST(LintTasks, EveryTaskThatWaitsIsNamedOnceWithTheSlowestItWaitsFor) {
  EXPECT_EQ(priorities({"A(INTERVAL := T#1ms, PRIORITY := 2)", "B(INTERVAL := T#5ms, PRIORITY := 1)",
                        "C(INTERVAL := T#5ms, PRIORITY := 9)", "D(INTERVAL := T#20ms, PRIORITY := 1)"}),
            "6 task A (every 1ms, priority 2), B (every 5ms, priority 1) and C (every 5ms, priority 9) can wait for "
            "whole scans of D (every 20ms, priority 1) | "
            "rate-monotonic priorities are A 0, B 1, C 1, D 2; or set priorities = \"rate-monotonic\" in [scheduler] "
            "of plc.toml");
  EXPECT_EQ(priorities({"A(INTERVAL := T#1ms, PRIORITY := 1)", "B(INTERVAL := T#5ms, PRIORITY := 1)",
                        "C(INTERVAL := T#10ms, PRIORITY := 3)", "D(INTERVAL := T#20ms, PRIORITY := 2)"}),
            "4 task A (every 1ms, priority 1) can wait for whole scans of B (every 5ms, priority 1); "
            "C (every 10ms, priority 3) can wait for whole scans of D (every 20ms, priority 2) | "
            "rate-monotonic priorities are A 0, B 1, C 2, D 3; or set priorities = \"rate-monotonic\" in [scheduler] "
            "of plc.toml");
}

TEST(LintTasks, ManyTasksAreCounted) {
  std::vector<std::string> tasks;
  for (int i = 1; i <= 9; ++i) tasks.push_back("T" + std::to_string(i) + "(INTERVAL := T#" + std::to_string(i) + "s)");
  const std::string found = priorities(tasks);
  EXPECT_NE(found.find("T4 (every 4s, priority 0) and 4 more can wait for whole scans of T9 (every 9s, priority 0) | "
                       "rate-monotonic priorities are T1 0, T2 1, T3 2, T4 3, ..; or"),
            std::string::npos)
      << found;
}

TEST(LintTasks, RateMonotonicOnesEqualIntervalsAndTasksWithoutIntervalAreFine) {
  EXPECT_EQ(priorities({"Fast(INTERVAL := T#10ms, PRIORITY := 0)", "Slow(INTERVAL := T#100ms, PRIORITY := 1)"}), "");
  EXPECT_EQ(priorities({"A(INTERVAL := T#10ms, PRIORITY := 5)", "B(INTERVAL := T#10ms, PRIORITY := 0)"}), "");
  EXPECT_EQ(priorities({"Fast(INTERVAL := T#10ms, PRIORITY := 1)", "Event(SINGLE := e, PRIORITY := 0)"}), "");
}

}  // namespace
}  // namespace plc
