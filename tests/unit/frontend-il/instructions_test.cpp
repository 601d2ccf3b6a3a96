// What instructions do: values, brackets, calls, jumps; and what is said of those that are wrong.
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>

#include "tests/support/golden.h"
#include "tests/unit/frontend-il/listed.h"

namespace plc::il {
namespace {

using test::Listed;

// ---- values -------------------------------------------------------------------------------------------------------

TEST(Load, AndStoreLeaveTheAccumulator) {
  Listed l("a : INT; b, c, d : INT;", "LD a\nST b\nST c, d");
  EXPECT_EQ(l.scan("a=5", "b c d"), "5 5 5");
}

TEST(Load, NegatesWithN) {
  Listed l("a, b, c : BOOL; w, v : WORD;", "LDN a\nST b\nSTN c\nLDN w\nST v");
  EXPECT_EQ(l.scan("a=0 w=1", "b c v"), "1 0 65534");
}

TEST(Literals, TakeTheTypeOfWhatTheyMeet) {
  Listed l("b : BOOL; u : USINT; r : REAL; t : TIME; i : INT := 3;",
           "LD 1\nST b\nLD 200\nST u\nLD 2\nADD 3\nST r\nLD T#5ms\nMUL 2\nST t\nLD 4\nADD i\nST i");
  EXPECT_EQ(l.scan("", "b u r t i"), "1 200 5 10000000 7");
}

TEST(Literals, TakeTheTypeOfTheAccumulatorNegatedAndInBrackets) {
  Listed l("w, a, b, c, d, e, f : WORD;",
           "LD w\nXORN 16#FF\nST a\nLD w\nANDN 16#FF\nST b\nLDN 16#FF\nST c\nLD w\nAND( 16#FF\nOR 1\n)\nST d\n"
           "LD w\nANDN( 16#FF\nOR 1\n)\nST e\nLD w\nANDN( 16#FF\n)\nST f");
  EXPECT_EQ(l.scan("w=4660", "a b c d e f"), "60724 4608 65280 52 4608 4608");
  // What a comparison makes of literals does not have the type that was there before the bracket.
  EXPECT_EQ(Listed("q : BOOL;", "LD TRUE\nAND( 5\nADD 2\nGT 3\n)\nST q").scan("", "q"), "1");
}

TEST(Literals, ThatDoNotFitAreRefused) { EXPECT_EQ(Listed("u : USINT;", "LD 300\nST u").codes(), "P4107"); }

TEST(Store, WidensLikeTexts) {
  EXPECT_EQ(Listed("i : INT := 7; d : DINT;", "LD i\nST d").scan("", "d"), "7");
  EXPECT_EQ(Listed("i : INT; d : DINT;", "LD d\nST i").codes(), "P4101");
}

TEST(Not, NegatesTheAccumulator) {
  Listed l("a, b : BOOL; w : WORD; c : BOOL;", "LD a NOT ST b\nLD w\nNOT\nST w\nLD 0\nNOT\nST c");
  EXPECT_EQ(l.scan("a=1 w=0", "b w c"), "0 65535 1");
}

TEST(SetAndReset, ActOnlyWhenTheAccumulatorIsTrue) {
  Listed l("s, r, q : BOOL;", "LD s\nS q\nLD r\nR q");
  EXPECT_EQ(l.scan("s=0 r=0", "q"), "0");
  EXPECT_EQ(l.scan("s=1", "q"), "1");
  EXPECT_EQ(l.scan("s=0", "q"), "1");
  EXPECT_EQ(l.scan("r=1", "q"), "0");
}

TEST(SetAndReset, NeedBool) { EXPECT_EQ(Listed("a : BOOL; i : INT;", "LD a\nS i").codes(), "P4101"); }

TEST(Lists, RepeatTheOperator) {
  EXPECT_EQ(Listed("i : INT;", "LD 7\nADD 2, 4, 7\nSUB 1, 1\nST i").scan("", "i"), "18");
}

TEST(Structures, AreWhatTheyWereWhenLoaded) {
  Listed l("p, q : Pair; c : Change;", "LD p\nCAL c(x := p)\nST q",
           "TYPE Pair : STRUCT a, b : INT; END_STRUCT END_TYPE\n"
           "FUNCTION_BLOCK Change VAR_IN_OUT x : Pair; END_VAR\nLD 9\nST x.a\nEND_FUNCTION_BLOCK\n");
  EXPECT_EQ(l.scan("", "p.a q.a"), "9 0");
}

// ---- brackets -----------------------------------------------------------------------------------------------------

TEST(Brackets, Nest) {
  Listed l("a, b, c, d, q : BOOL;", "LD a\nAND( b\nOR( c\nAND d\n)\n)\nST q");
  EXPECT_EQ(l.scan("a=1 b=0 c=1 d=1", "q"), "1");
  EXPECT_EQ(l.scan("d=0", "q"), "0");
  EXPECT_EQ(l.scan("b=1", "q"), "1");
  EXPECT_EQ(l.scan("a=0", "q"), "0");
}

TEST(Brackets, BeginWithAnOperandOrALoad) {
  EXPECT_EQ(Listed("i : INT; IN : INT := 4;", "LD 2\nMUL( LD IN\nADD 1\n)\nST i").scan("", "i"), "10");
  EXPECT_EQ(Listed("i : INT; IN : INT := 4;", "LD 2\nMUL(\nLD IN\nADD 1\n)\nST i").scan("", "i"), "10");
  EXPECT_EQ(Listed("i : INT; IN : INT := 4;", "LD 2\nMUL( IN\nADD 1\n)\nST i").scan("", "i"), "10");
}

TEST(Brackets, AreNegatedByN) {
  Listed l("a, b, q : BOOL;", "LD a\nANDN( b\nOR FALSE )\nST q");
  EXPECT_EQ(l.scan("a=1 b=0", "q"), "1");
  EXPECT_EQ(l.scan("b=1", "q"), "0");
}

TEST(Brackets, OfDepthBeyondAnyStack) {
  std::string body = "LD 1\n";
  for (int i = 0; i < 20000; ++i) body += "ADD( 1\n";
  for (int i = 0; i < 20000; ++i) body += ")\n";
  EXPECT_EQ(Listed("d : DINT;", body + "ST d").scan("", "d"), "20001");
}

TEST(Brackets, ThatDoNotFitAreNamed) {
  EXPECT_EQ(Listed("a : BOOL;", "LD a\nAND( a\nST a").codes(), "P4504");
  EXPECT_EQ(Listed("a : BOOL;", "LD a )\nST a").codes(), "P4504");
  EXPECT_EQ(Listed("a : BOOL;", "LD a\nAND( a\nJMP on\n)\non: ST a").codes(), "P4504");
  EXPECT_EQ(Listed("a : BOOL;", "LD a\nAND( a\non: OR a\n)\nST a\nJMP on").codes(), "P4504");
  EXPECT_EQ(Listed("a : BOOL;", "LD a\nAND( a\nRETC\n)\nST a").codes(), "P4504");
  EXPECT_EQ(Listed("a : BOOL;", "LD a\nLD ( a )\nST a").codes().substr(0, 5), "P4504");
}

// ---- calls --------------------------------------------------------------------------------------------------------

TEST(Call, TakesNamedAndPlacedArguments) {
  Listed l("t : TON; q, n : BOOL; x : TIME;",
           "CAL t(IN := TRUE,\n  PT := T#15ms,\n  NOT Q => n, ET => x)\nLD t.Q\nST q");
  EXPECT_EQ(l.scan("", "q n"), "0 1");
  EXPECT_EQ(l.scan("", "q n x"), "0 1 10000000");
  EXPECT_EQ(l.scan("", "q n x"), "1 0 15000000");
  EXPECT_EQ(Listed("t : TON; q : BOOL;", "CAL t(TRUE, T#0s)\nLD t.Q\nST q").scan("", "q"), "1");
}

TEST(Call, FollowsItsCondition) {
  Listed l("a : BOOL; c : Count; d : Count;", "LD a\nCALC c\nLD a\nCALCN d",
           "FUNCTION_BLOCK Count VAR_OUTPUT n : INT; END_VAR\nLD n\nADD 1\nST n\nEND_FUNCTION_BLOCK\n");
  EXPECT_EQ(l.scan("a=1", "c.n d.n"), "1 0");
  EXPECT_EQ(l.scan("a=0", "c.n d.n"), "1 1");
}

TEST(Call, OfAnActionAndAProgram) {
  Listed l("n : INT;", "CAL Step\nACTION Step:\nLD n\nADD 2\nST n\nEND_ACTION");
  EXPECT_EQ(l.scan("", "n"), "2");
}

TEST(InputOperators, GiveAnInputAndCall) {
  Listed l("up : BOOL; c : CTU; n : INT; s, r : BOOL; f : SR;",
           "LD 2\nPV c\nLD up\nCU c\nLD c.CV\nST n\nLD s\nS1 f\nLD r\nR f");
  EXPECT_EQ(l.scan("up=1", "n"), "1");
  EXPECT_EQ(l.scan("up=1", "n"), "1") << "no second edge";
  EXPECT_EQ(l.scan("up=0", "n"), "1");
  EXPECT_EQ(l.scan("up=1", "n c.Q"), "2 1");
  EXPECT_EQ(l.scan("s=1", "f.Q1"), "1");
  EXPECT_EQ(l.scan("s=0 r=1", "f.Q1"), "0");
}

TEST(Function, TakesTheAccumulatorAsItsFirstArgument) {
  EXPECT_EQ(Listed("i : INT;", "LD 1\nLIMIT 5, 3\nST i").scan("", "i"), "3");
  EXPECT_EQ(Listed("r : REAL := 16.0;", "LD r\nSQRT\nSQRT\nST r").scan("", "r"), "2") << "functions without operands";
  EXPECT_EQ(Listed("i : INT;", "LIMIT(MN := 1,\n IN := 9,\n MX := 4)\nST i").scan("", "i"), "4");
  EXPECT_EQ(Listed("i : INT;", "ADD(IN1 := 1, IN2 := 9)\nST i").scan("", "i"), "10");
  EXPECT_EQ(Listed("i : INT;", "LD 4\nTwice\nST i",
                   "FUNCTION Twice : INT VAR_INPUT x : INT; END_VAR\nLD x\nMUL 2\nST Twice\nEND_FUNCTION\n")
                .scan("", "i"),
            "8");
}

TEST(Function, CalledWithCalWarns) {
  Listed l("r : REAL;", "LD 9.0\nCAL SQRT\nST r");
  EXPECT_EQ(l.codes(), "P4510");
  EXPECT_EQ(l.scan("", "r"), "3");
  EXPECT_EQ(Listed("a : BOOL; r : REAL;", "LD a\nCALC SQRT\nST r").codes(), "P4509");
}

TEST(Accumulator, AfterACallIsWhatItWasAndWarns) {
  Listed l("a, b : BOOL; t : TON;", "LD a\nCAL t\nST b");
  EXPECT_EQ(l.codes(), "P4508");
  EXPECT_EQ(l.scan("a=1", "b"), "1");
  EXPECT_EQ(Listed("a, b : BOOL; t : TON;", "LD a\nST t.IN\nCAL t\nLD t.Q\nST b").codes(), "");
}

// ---- jumps --------------------------------------------------------------------------------------------------------

TEST(Jumps, KeepTheAccumulatorWhereWaysMeet) {
  Listed l("reset : BOOL; cnt, out : INT;",
           "LD reset\nJMPC clear\n(* count *)\nLD cnt\nADD 1\nJMP quit\nclear:\n(* from the start *)\nLD 0\nquit:\nST "
           "cnt\nST out");
  EXPECT_EQ(l.codes(), "");
  EXPECT_EQ(l.scan("reset=0", "out"), "1");
  EXPECT_EQ(l.scan("", "out"), "2");
  EXPECT_EQ(l.scan("reset=1", "out"), "0");
}

TEST(Jumps, GoBack) {
  Listed l("i, sum : INT;", "LD 0\nST i, sum\nagain:\nLD i\nADD 1\nST i\nADD sum\nST sum\nLD i\nLT 10\nJMPC again");
  EXPECT_EQ(l.scan("", "sum i"), "55 10");
}

TEST(Jumps, CarryALoopInTheAccumulator) {
  EXPECT_EQ(Listed("i : INT;", "LD 1\nmore: MUL 2\nST i\nLT 100\nJMPCN done\nLD i\nJMP more\ndone: LD i\nADD 1\nST i")
                .scan("", "i"),
            "129");
}

TEST(Jumps, IntoALoopFromBefore) {
  // The test is entered first: no block before "body" in the text leads to it.
  Listed l(
      "n, k : INT;",
      "LD 5\nJMP test\nbody: SUB 1\nST k\nLD n\nADD 1\nST n\nLD k\ntest: ST k\nGT 0\nJMPCN out\nLD k\nJMP body\nout:");
  EXPECT_EQ(l.scan("", "n k"), "5 0");
}

TEST(Jumps, ToTheEnd) { EXPECT_EQ(Listed("n : INT;", "LD TRUE\nJMPC end\nLD 1\nST n\nend:").scan("", "n"), "0"); }

TEST(Return, EndsTheBody) {
  Listed l("a : BOOL; n : INT;", "LD a\nRETC\nLD n\nADD 1\nST n\nRET\nLD 100\nST n");
  EXPECT_EQ(l.scan("a=0", "n"), "1");
  EXPECT_EQ(l.scan("a=1", "n"), "1");
}

TEST(Ways, OfDifferentTypesAreRefused) {
  Listed l("a : BOOL; i : INT; r : REAL;", "LD a\nJMPC other\nLD i\nJMP meet\nother: LD r\nmeet: ST r");
  EXPECT_EQ(l.codes(), "P4506");
  EXPECT_EQ(l.message().substr(0, 60), "the accumulator is REAL on this way and INT on that of line ");
}

TEST(Ways, OfDifferentTypesAreFineWhereNobodyReads) {
  EXPECT_EQ(
      Listed("a : BOOL; i : INT; r : REAL;", "LD a\nJMPC other\nLD i\nJMP meet\nother: LD r\nmeet: LD i\nST i").codes(),
      "");
}

TEST(Ways, WithoutAValueAreNamed) {
  EXPECT_EQ(Listed("a : BOOL;", "ST a").codes(), "P4507");
  EXPECT_EQ(Listed("a : BOOL;", "JMP on\non: ST a").codes(), "P4507");
  EXPECT_EQ(Listed("a : BOOL;", "LD a\nAND(\n)\nST a").codes(), "P4503");
}

TEST(Ways, OfTextsMeet) {
  Listed l("a : BOOL; s : STRING;", "LD a\nJMPC other\nLD 'on'\nJMP meet\nother: LD 'stopped'\nmeet: ST s");
  EXPECT_EQ(l.scan("a=0", "s"), "'on'");
  EXPECT_EQ(l.scan("a=1", "s"), "'stopped'");
}

TEST(Labels, AreFoundOrNamed) {
  EXPECT_EQ(Listed("a : BOOL;", "LD a\nJMPC nowhere\nST a").codes(), "P4505");
  EXPECT_EQ(Listed("a : BOOL;", "on: LD a\non: ST a\nJMP on").codes(), "P4505");
  EXPECT_EQ(Listed("a : BOOL;", "LD a\nJMPC Finished\nfinished: LD a\nST a").codes(), "") << "in any letter case";
}

// What a list becomes: no variable for the accumulator inside of a block, one where ways meet; the loop entered from
// below comes after the jump that enters it.
TEST(Golden, Listing) {
  Listed l("reset, a, b, q : BOOL; cnt, k, n : INT;",
           "LD reset\nJMPC clear\nLD cnt\nADD 1\nJMP quit\nclear:\nLD 0\nquit:\nST cnt\n"
           "LD a\nAND( b\nORN q\n)\nST q\n"
           "LD 5\nJMP test\nbody:\nSUB 1\nST k\ntest:\nST n\nGT 0\nJMPCN out\nLD n\nJMP body\nout:\nLD q\nRETC\nR a");
  test::expect_golden("tests/golden/instruction-list.txt", l.listing());
}

// ---- what is wrong ------------------------------------------------------------------------------------------------

TEST(Mistakes, AreReportedOnceAndReadingGoesOn) {
  EXPECT_EQ(Listed("a : BOOL;", "LD a\nFOO a\nST a\nANDN\nST a").codes(), "P4503 P4502");
  EXPECT_EQ(Listed("a : BOOL;", "LD\nST a").codes(), "P4503");
  EXPECT_EQ(Listed("a : BOOL;", "LD a\nNOT a\nST a").codes(), "P4503");
  EXPECT_EQ(Listed("i : INT;", "LD i\nGT 1, 2\nLD i\nST i").codes(), "P4503");
  EXPECT_EQ(Listed("a : BOOL;", "LD a\nJMP\nl: ST a").codes(), "P4503");
  EXPECT_EQ(Listed("a : BOOL;", "LD nothing\nST a").codes(), "P4004");
  EXPECT_EQ(Listed("a : BOOL; t : TON;", "LD a\nt(IN := a)\nST a").codes(), "P4502");
  EXPECT_EQ(Listed("a, b : BOOL;", "LD a\nST b\nIF a THEN\nLD a\nST b").codes(), "P4502");
}

TEST(Words, OfOperatorsAreNamesOfVariables) {
  Listed l("IN, PT, S, R, LD, CU : BOOL := TRUE;", "LD IN\nAND PT\nAND S AND R\nAND LD ST CU");
  EXPECT_EQ(l.scan("PT=0", "CU"), "0");
}

TEST(Lines, MayBeJoined) {
  Listed l("x, y : INT := 2; q : BOOL;", "LD x ADD y (* joined *) MUL 2; ST x LD x // rest\nGT 7 ST q");
  EXPECT_EQ(l.scan("", "x q"), "8 1");
}

// ---- conditions ---------------------------------------------------------------------------------------------------

struct Conditions : testing::Test {
  std::optional<ir::Operand> lower(const std::string& text) {
    project = st::read_memory("PROGRAM Main VAR a, b : BOOL; i : INT; END_VAR END_PROGRAM", "test.st", diagnostics);
    module = st::declare(*project, {}, diagnostics);
    builder = std::make_unique<ir::Builder>(*module, 0, diagnostics);
    core::SourceRef at;
    at.line = at.column = 1;
    return lower_value(text, at, *builder);
  }
  core::Diagnostics diagnostics;
  std::unique_ptr<plcopen::Project> project;
  std::unique_ptr<ir::Module> module;
  std::unique_ptr<ir::Builder> builder;
};

TEST_F(Conditions, AreTheValueAtTheEnd) {
  const auto value = lower("LD a\nANDN b");
  ASSERT_TRUE(value);
  EXPECT_EQ(builder->type_of(value->value), ir::kBoolType);
}

TEST_F(Conditions, OfEveryWayThere) {
  const auto value = lower("LD a\nRETC\nLD i\nGT 5");
  ASSERT_TRUE(value);
  EXPECT_EQ(builder->type_of(value->value), ir::kBoolType);
  EXPECT_FALSE(lower("LD a\nJMPC end\nLD i\nend:"));
  EXPECT_EQ(diagnostics.all().back().code, core::Code::P4506);
}

TEST_F(Conditions, NeedAValue) {
  EXPECT_FALSE(lower(""));
  EXPECT_EQ(diagnostics.error_count(), 1u);
  EXPECT_FALSE(lower("on: JMP on"));
  EXPECT_EQ(diagnostics.error_count(), 2u);
}

}  // namespace
}  // namespace plc::il
