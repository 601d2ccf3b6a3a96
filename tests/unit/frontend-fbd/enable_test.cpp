// EN and ENO: what is executed, what wires carry where it is not, who writes nothing; blocks that declare EN
// themselves; EXECUTE boxes; boxes that a closed branch skips.
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "tests/unit/frontend-fbd/diagram.h"

namespace plc {
namespace {

using ir::Op;
using test::Diagram;
using test::Sketch;

constexpr const char* kVariables =
    "A, B, good, Y : BOOL; n, m, sum, seen : INT; v : STRING; list : ARRAY [1..2] OF INT; c : CTU; mine : Own;";

constexpr const char* kOthers =
    "FUNCTION Two : INT VAR_INPUT x : INT := 7; END_VAR VAR_OUTPUT more : INT := 3; END_VAR "
    "Two := x * 2; more := x + 1; END_FUNCTION\n"
    "FUNCTION Judge : INT VAR_INPUT EN : BOOL; x : INT; END_VAR VAR_OUTPUT ENO : BOOL; END_VAR "
    "Judge := x; ENO := x > 5; END_FUNCTION\n"
    "FUNCTION_BLOCK Own VAR_INPUT EN : BOOL; x : INT; END_VAR VAR_OUTPUT ENO : BOOL; last : INT; END_VAR "
    "last := x; ENO := x > 5; END_FUNCTION_BLOCK\n";

/// A block 2 with EN on A and its outputs wired to outVariables: `outputs` are pins with a variable each.
struct Enabled : Diagram {
  Enabled(const std::string& type, const std::string& inputs, const std::string& pins,
          const std::vector<std::pair<std::string, std::string>>& outputs)
      : Diagram(kVariables, drawn(type, inputs, pins, outputs), kOthers) {}

  static Sketch drawn(const std::string& type, const std::string& inputs, const std::string& pins,
                      const std::vector<std::pair<std::string, std::string>>& outputs) {
    Sketch s;
    s.in(1, "A");
    s.block(2, type, "EN=1 " + inputs, pins);
    std::int64_t id = 3;
    for (const auto& [pin, variable] : outputs) s.out(id++, variable, "2." + pin);
    return s;
  }
};

TEST(Enable, OfAFunctionThatIsFalseWritesNoVariable) {
  Enabled d("ADD", "IN1:=n IN2:=1", "OUT", {{"OUT", "sum"}});
  EXPECT_EQ(d.scan("A=0 n=1 sum=40", "sum"), "40");
  EXPECT_EQ(d.scan("A=1", "sum"), "2");
  EXPECT_EQ(d.scan("A=0 n=5", "sum"), "2");
}

TEST(Enable, OfAFunctionThatIsFalseGivesTheDefaultToBlocks) {
  Sketch s;
  s.in(1, "A");
  s.block(2, "ADD", "EN=1 IN1:=n IN2:=1", "OUT");
  s.block(3, "MUL", "IN1=2.OUT IN2:=10", "OUT=>sum");
  s.block(4, "CONCAT", "EN=1 IN1:=v IN2:='x'", "OUT");
  s.block(5, "LEN", "IN=4.OUT", "OUT=>seen");
  s.block(6, "GT", "EN=1 IN1:=n IN2:=0", "!OUT=>Y");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.scan("A=1 n=3 v='ab'", "sum seen Y"), "40 3 0");
  EXPECT_EQ(d.scan("A=0", "sum seen"), "0 0");
}

TEST(Enable, OfACompareBoxIsAnAndNotAJump) {
  Enabled compare("GT", "IN1:=n IN2:=5", "OUT", {{"OUT", "Y"}});
  EXPECT_EQ(compare.count(Op::kJumpIfNot), 1u) << "only around the outVariable\n" << compare.listing();
  EXPECT_EQ(compare.scan("A=1 n=6", "Y"), "1");
  Enabled number("ADD", "IN1:=n IN2:=5", "OUT", {{"OUT", "sum"}});
  EXPECT_EQ(number.count(Op::kJumpIfNot), 2u);
}

TEST(Enable, OfAFunctionOfTheProjectGivesItsInitialValues) {
  Sketch s;
  s.in(1, "A");
  s.block(2, "Two", "EN=1 x:=n", "Two more");
  s.block(3, "MOVE", "IN=2.Two", "OUT=>sum");
  s.block(4, "MOVE", "IN=2.more", "OUT=>seen");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.scan("A=1 n=5", "sum seen"), "10 6");
  EXPECT_EQ(d.scan("A=0", "sum seen"), "0 3");
}

TEST(Enable, OfAFunctionBlockThatIsFalseKeepsItsOutputs) {
  Enabled d("CTU c", "CU:=B PV:=2", "Q CV", {{"CV", "sum"}});
  EXPECT_EQ(d.scan("A=1 B=1", "sum c.CV"), "1 1");
  EXPECT_EQ(d.scan("A=0 B=0 sum=9", "sum c.CV"), "9 1") << "not written, though the wire carries 1";
  EXPECT_EQ(d.scan("B=1", "c.CV"), "1");
  EXPECT_EQ(d.scan("A=1", "c.CV"), "1") << "the fall was not seen, so this is no rise";
}

TEST(Enable, SeveralWiresAndSeveralPinsAreAllAsked) {
  Sketch s;
  s.in(1, "A");
  s.in(2, "B");
  s.block(3, "ADD", "EN=1|2 IN1:=n IN2:=1", "OUT=>sum");
  s.block(4, "ADD", "EN=1 !EN=2 IN1:=n IN2:=2", "OUT=>seen");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.scan("A=1 B=0 n=1", "sum seen"), "2 3");
  EXPECT_EQ(d.scan("A=1 B=1 n=2", "sum seen"), "3 3") << "OR of wires, AND of pins";
  EXPECT_EQ(d.scan("A=0 B=0 n=3", "sum seen"), "3 3");
}

TEST(Enable, WithoutAWireIsTrue) {
  Sketch s;
  s.block(1, "ADD", "EN IN1:=n IN2:=1", "ENO=>good OUT=>sum");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.scan("n=1", "good sum"), "1 2");
  EXPECT_EQ(d.count(Op::kJumpIfNot), 0u);
}

TEST(Enable, MayBeATextAtThePin) {
  Sketch s;
  s.block(1, "ADD", "EN:=A IN1:=n IN2:=1", "OUT=>sum");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.scan("A=1 n=1", "sum"), "2");
  EXPECT_EQ(d.scan("A=0 n=2", "sum"), "2");
}

// ---- ENO ----------------------------------------------------------------------------------------------------------

TEST(Enable, EnoHasTheModifiersOfItsPin) {
  Enabled negated("ADD", "IN1:=n IN2:=1", "OUT !ENO", {{"ENO", "good"}});
  EXPECT_EQ(negated.scan("A=1", "good"), "0");
  EXPECT_EQ(negated.scan("A=0", "good"), "1");
  Enabled edge("Own mine", "x:=n", "^ENO last", {{"ENO", "good"}});
  EXPECT_EQ(edge.scan("A=1 n=6", "good"), "1");
  EXPECT_EQ(edge.scan("n=6", "good"), "0");
  EXPECT_EQ(edge.scan("n=1", "good"), "0");
  EXPECT_EQ(edge.scan("n=6", "good"), "1");
}

TEST(Eno, IsFalseAfterAnEventAndTheResultIsWritten) {
  Enabled d("DIV", "IN1:=n IN2:=m", "OUT ENO", {{"OUT", "sum"}, {"ENO", "good"}});
  EXPECT_EQ(d.scan("A=1 n=8 m=2", "sum good"), "4 1");
  EXPECT_EQ(d.scan("m=0 sum=5", "sum good"), "0 0");
  EXPECT_EQ(d.scan("A=0 m=2", "sum good"), "0 0");
}

TEST(Eno, ThatNobodyReadsCostsNothing) {
  Enabled unread("DIV", "IN1:=n IN2:=m", "OUT ENO", {{"OUT", "sum"}});
  EXPECT_EQ(unread.count(Op::kEno), 0u);
  EXPECT_EQ(unread.count(Op::kClearEvent), 0u);
  Enabled read("DIV", "IN1:=n IN2:=m", "OUT ENO", {{"ENO", "good"}});
  EXPECT_EQ(read.count(Op::kEno), 1u);
  EXPECT_EQ(read.count(Op::kClearEvent), 1u);
}

TEST(Eno, OfWhatHasNoEventsIsEn) {
  Enabled d("ADD", "IN1:=n IN2:=1", "OUT ENO", {{"ENO", "good"}});
  EXPECT_EQ(d.count(Op::kEno), 0u);
  EXPECT_EQ(d.over("A", "1 0 1", "good"), "1 0 1");
}

TEST(Eno, OfAnEventInsideAFunctionOfTheProject) {
  Sketch s;
  s.block(1, "Divide", "x:=n", "Divide=>sum ENO=>good");
  Diagram d(kVariables, s,
            std::string(kOthers) + "FUNCTION Divide : INT VAR_INPUT x : INT; END_VAR Divide := 10 / x; END_FUNCTION");
  EXPECT_EQ(d.scan("n=5", "sum good"), "2 1");
  EXPECT_EQ(d.scan("n=0", "sum good"), "0 0");
}

TEST(Eno, OfABlockThatDeclaresItIsWhatItsBodySets) {
  Enabled d("Own mine", "x:=n", "ENO last", {{"ENO", "good"}, {"last", "sum"}});
  EXPECT_EQ(d.scan("A=1 n=6", "good sum"), "1 6");
  EXPECT_EQ(d.scan("n=4", "good sum"), "0 4");
  EXPECT_EQ(d.scan("A=0 n=9 sum=1", "good sum mine.last mine.EN"), "0 1 4 0");
}

TEST(Eno, OfAFunctionThatDeclaresIt) {
  Enabled d("Judge", "x:=n", "Judge ENO", {{"ENO", "good"}, {"Judge", "sum"}});
  EXPECT_EQ(d.scan("A=1 n=6", "good sum"), "1 6");
  EXPECT_EQ(d.scan("n=4", "good sum"), "0 4");
  EXPECT_EQ(d.scan("A=0 n=9", "good sum"), "0 4");
}

TEST(Eno, ADeclaredEnWithoutAWireIsTrueInEveryScan) {
  Sketch s;
  s.block(1, "Own mine", "x:=n", "last=>sum");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.scan("n=6", "sum"), "6");
}

TEST(Eno, ChainsBoxes) {
  Sketch s;
  s.in(1, "A");
  s.block(2, "DIV", "EN=1 IN1:=n IN2:=m", "OUT ENO");
  s.block(3, "ADD", "EN=2.ENO IN1=2.OUT IN2:=1", "OUT=>sum ENO=>good");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.scan("A=1 n=8 m=2", "sum good"), "5 1");
  EXPECT_EQ(d.scan("m=0", "sum good"), "5 0");
}

// ---- EXECUTE boxes ------------------------------------------------------------------------------------------------

TEST(Execute, RunsItsStUnderEn) {
  Sketch s;
  s.in(1, "A");
  s.execute(2, "sum := sum + n; seen := 10 / n;", "EN=1", "ENO=>good");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.scan("A=1 n=2", "sum seen good"), "2 5 1");
  EXPECT_EQ(d.scan("A=0", "sum good"), "2 0");
  EXPECT_EQ(d.scan("A=1 n=0", "sum seen good"), "2 0 0");
}

TEST(Execute, AnyOtherOutputIsItsEno) {
  Sketch s;
  s.in(1, "A");
  s.execute(2, "n := n + 1;", "EN=1", "Out1");
  s.out(3, "Y", "2.Out1");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.over("A", "1 0", "Y"), "1 0");
}

TEST(Execute, WithoutTextOrWithAWrongOne) {
  Sketch s;
  s.execute(1, "", "", "ENO=>good");
  EXPECT_EQ(Diagram(kVariables, s, kOthers).scan("", "good"), "1");
  Sketch wrong;
  wrong.execute(1, "n := ;", "", "ENO");
  wrong.out(2, "Y", "1.ENO");
  Diagram d(kVariables, wrong, kOthers);
  EXPECT_EQ(d.diagnostics.error_count() + static_cast<std::size_t>(!d.codes().empty()), 1u) << d.codes();
}

// ---- closed branches ----------------------------------------------------------------------------------------------

TEST(ShortCircuit, SkipsTheBoxesThatALineWithoutBoxesBypasses) {
  Sketch s;
  s.in(1, "A");
  s.block(2, "CTU c", "CU=1 PV:=1", "Q CV");
  s.in(3, "B");
  s.out(4, "Y", "9");
  s.out(5, "sum", "2.CV");
  s.close(9, true, "1", {"2.Q", "3"});
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.scan("A=0 B=1", "Y c.CV"), "1 0");
  EXPECT_EQ(d.scan("A=1", "Y c.CV"), "1 0") << "skipped";
  EXPECT_EQ(d.scan("B=0", "Y c.CV sum"), "1 1 1") << "the rise is seen now";
}

}  // namespace
}  // namespace plc
