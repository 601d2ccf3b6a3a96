// What a box is, and which of its pins a wire means: instances, functions, in-outs, actions, programs, DELAY; what is
// reported of boxes.
#include <gtest/gtest.h>

#include <string>

#include "tests/unit/frontend-fbd/diagram.h"

namespace plc {
namespace {

using ir::Op;
using test::Diagram;
using test::Sketch;

constexpr const char* kVariables =
    "A, B, Y : BOOL; n, m, sum, seen : INT; r : REAL; d : DATE; t, t2 : TON; c : CTU; bump : Bump; tank : Tank; "
    "flip, flip2 : Flip; list : ARRAY [1..3] OF INT; many : ARRAY [1..2] OF TON; w : WORD;";

constexpr const char* kOthers =
    "FUNCTION_BLOCK Bump VAR_INPUT step : INT := 1; END_VAR VAR_IN_OUT IO : INT; END_VAR VAR_OUTPUT before : INT; "
    "END_VAR before := IO; IO := IO + step; END_FUNCTION_BLOCK\n"
    "FUNCTION_BLOCK Flip VAR_IN_OUT v : BOOL; END_VAR v := NOT v; END_FUNCTION_BLOCK\n"
    "FUNCTION_BLOCK Tank VAR_INPUT rate : INT; END_VAR VAR_OUTPUT level : INT; END_VAR END_FUNCTION_BLOCK\n"
    "ACTION Tank.Fill level := level + rate; END_ACTION\n"
    "ACTION Main.Twice n := n * 2; END_ACTION\n"
    "FUNCTION Minus : INT VAR_INPUT a : INT := 10; b : INT := 4; END_VAR Minus := a - b; END_FUNCTION\n"
    "FUNCTION Larger : INT VAR_IN_OUT CONSTANT x, y : INT; END_VAR Larger := MAX(x, y); END_FUNCTION\n"
    "FUNCTION Total : INT VAR_IN_OUT CONSTANT v : ARRAY [1..3] OF INT; END_VAR Total := v[1] + v[2] + v[3]; "
    "END_FUNCTION\n"
    "VAR_GLOBAL CONSTANT Fixed : INT := 7; Row : ARRAY [1..3] OF INT := [3, 4, 1]; END_VAR\n"
    "FUNCTION Swap : INT VAR_IN_OUT x, y : INT; END_VAR Swap := x; x := y; y := Swap; END_FUNCTION\n";

// ---- pins ---------------------------------------------------------------------------------------------------------

struct Pins {
  const char* name;
  const char* type;
  const char* inputs;
  const char* outputs;
  const char* codes;
  const char* sum;  ///< after a scan with n = 9, m = 2
};

void PrintTo(const Pins& pins, std::ostream* out) { *out << pins.name; }

class PinsOf : public testing::TestWithParam<Pins> {};

TEST_P(PinsOf, Blocks) {
  const Pins& row = GetParam();
  Sketch s;
  s.block(1, row.type, row.inputs, row.outputs);
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.codes(), row.codes) << d.message();
  if (row.sum == nullptr) return;
  EXPECT_EQ(d.scan("n=9 m=2", "sum"), row.sum);
}

INSTANTIATE_TEST_SUITE_P(
    Pins, PinsOf,
    testing::Values(
        Pins{"StandardByName", "SUB", "IN2:=n IN1:=m", "OUT=>sum", "", "-7"},
        Pins{"StandardInAnyCase", "sub", "in2:=n In1:=m", "out=>sum", "", "-7"},
        Pins{"StandardByPlaceWhereNoNameContradicts", "SUB", "foo:=n IN2:=m", "OUT=>sum", "", "7"},
        Pins{"StandardStrangeNamesTakeWhatIsLeft", "SUB", "IN2:=n foo:=m", "OUT=>sum", "P3025", "-7"},
        Pins{"StandardInOneOrderWithItsNames", "LIMIT", "IN:=n MIN:=1 MAX:=4", "OUT=>sum", "P3025 P3025", "4"},
        Pins{"StandardInputTwice", "SUB", "IN2:=n IN2:=m", "OUT=>sum", "P3011", nullptr},
        Pins{"StandardCountedPinsAreNoNames", "SEL", "In1:=TRUE In2:=m In3:=n", "Out1=>sum", "", "9"},
        Pins{"StandardCountedAfterEn", "MUX", "EN:=TRUE In2:=0 In3:=n In4:=m", "Out2=>sum", "", "9"},
        Pins{"StandardResultOfAnyName", "SUB", "IN1:=n IN2:=m", "whatever=>sum", "", "7"},
        Pins{"ExtensibleTakesThePinsThatAreWired", "ADD", "IN1:=n IN2 IN3:=m", "OUT=>sum", "", "11"},
        Pins{"ExtensibleNeedsTwo", "ADD", "IN1:=n IN2 IN3", "OUT=>sum", "P3010", nullptr},
        Pins{"SelectionMayEndEarly", "MUX", "K:=m IN0:=1 IN1:=3 IN2:=5 IN3", "OUT=>sum", "", "5"},
        Pins{"SelectionCountsItsPins", "MUX", "K:=m IN0:=1 IN1 IN2:=5", "OUT=>sum", "P3010", nullptr},
        Pins{"SelectionNeedsItsNumber", "MUX", "K IN0:=1 IN1:=3 IN2:=5", "OUT=>sum", "P3010", nullptr},
        Pins{"StandardNeedsAll", "SUB", "IN1:=n IN2", "OUT=>sum", "P3010", nullptr},
        Pins{"StandardWithTooFewDrawn", "SUB", "IN1:=n", "OUT=>sum", "P3010", nullptr},
        Pins{"ProjectByName", "Minus", "b:=n a:=m", "Minus=>sum", "", "-7"},
        Pins{"ProjectByPlaceWithAWarning", "Minus", "foo=5 b:=m", "Minus=>sum", "P3001", "8"},
        Pins{"ProjectTakesInitialValues", "Minus", "b:=m", "Minus=>sum", "", "8"},
        Pins{"ProjectHasNoThirdInput", "Minus", "a:=n b:=m c:=n", "Minus=>sum", "P3011", nullptr},
        Pins{"ProjectHasNoSecondOutput", "Minus", "a:=n b:=m", "Minus=>sum other=>seen", "P3011", nullptr},
        Pins{"BlockInputTwice", "Tank tank", "rate:=n RATE:=m", "level=>sum", "P3011", nullptr},
        Pins{"BlockWithoutSuchOutput", "Tank tank", "rate:=n", "level=>sum other=>seen", "P3011", nullptr},
        Pins{"BlockOutputAtThePlaceOfOneThatIsDrawn", "CTU c", "CU:=A PV:=n", "CV=>sum Full=>Y", "P3011", nullptr},
        Pins{"TextAtAStrangeInput", "CTU c", "CLK:=A R:=B PV:=n", "CV=>sum", "P3025", "0"},
        Pins{"BlockByAlias", "CTU c", "CU:=A RESET:=B PV:=n", "CV=>sum", "", "0"}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(Pins, OfAnotherNameAreReadByTheirPlaceWithAWarning) {
  Sketch s;
  s.in(1, "n");
  s.block(2, "Tank tank", "speed=1", "height=>sum");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.codes(), "P3025 P3025");
  EXPECT_NE(d.message().find("Tank \"tank\" has no input \"speed\"; by its place it is read as \"rate\""),
            std::string::npos)
      << d.message();
  EXPECT_EQ(d.scan("n=5", "tank.rate"), "5");
}

TEST(Pins, WithoutANameAreReadByTheirPlaceInSilence) {
  Sketch s;
  s.in(1, "n");
  auto& block = s.block(2, "Tank tank", "", "");
  test::BodyBuilder::feed(block, {1});
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.codes(), "");
  EXPECT_EQ(d.scan("n=5", "tank.rate"), "5");
}

// ---- instances ----------------------------------------------------------------------------------------------------

TEST(Instance, KeepsInputsThatAreNotWired) {
  Sketch s;
  s.block(1, "TON t", "IN:=A PT", "Q=>Y");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.scan("A=1 t.PT=10000000", "Y"), "0");
  EXPECT_EQ(d.scan("", "Y"), "1");
}

TEST(Instance, MayBeAnElementOfAnArray) {
  Sketch s;
  s.block(1, "TON many[2]", "IN:=A PT:=T#0s", "Q=>Y");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.scan("A=1", "Y many[1].Q many[2].Q"), "1 0 1");
}

TEST(Instance, RunsAnActionWithItsInputs) {
  for (const char* type : {"tank.Fill", "Fill tank"}) {
    Sketch s;
    s.block(1, type, "rate:=n", "level=>sum");
    Diagram d(kVariables, s, kOthers);
    EXPECT_EQ(d.codes(), "") << type;
    EXPECT_EQ(d.scan("n=4", "sum"), "4") << type;
    EXPECT_EQ(d.scan("n=5", "sum"), "9") << type;
  }
}

TEST(Instance, OfThePouItselfRunsItsActions) {
  Sketch s;
  s.in(1, "A");
  s.block(2, "Twice", "EN=1", "ENO=>Y");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.scan("A=1 n=4", "n Y"), "8 1");
  EXPECT_EQ(d.scan("A=0", "n Y"), "8 0");
}

// ---- in-outs ------------------------------------------------------------------------------------------------------

TEST(InOut, WorksOnTheVariableThatIsWiredToIt) {
  Sketch s;
  s.in(1, "list[2]");
  s.block(2, "Bump bump", "step:=3", "before=>seen", "IO=1");
  s.out(3, "sum", "2.IO");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.scan("list[2]=5", "list[2] seen sum"), "8 5 8");
}

TEST(InOut, IsFoundAmongInputsAndThroughConnectorsAndOtherBlocks) {
  Sketch s;
  s.in_out(1, "n");
  s.connector(2, "K", "1");
  s.continuation(3, "K");
  s.block(4, "Bump bump", "IO=3", "", "");
  s.block(5, "Bump bump", "step:=10", "", "IO=6.IO");
  s.block(6, "Bump bump", "step:=100", "", "IO=1");
  s.out(7, "sum", "5.IO");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.codes(), "");
  EXPECT_EQ(d.scan("n=1", "n sum"), "112 112") << "1 from the block above, 100 and 10 from those in a chain";
}

TEST(InOut, OfAFunction) {
  Sketch s;
  s.in(1, "n");
  s.in(2, "m");
  s.block(3, "Swap", "", "Swap=>sum", "x=1 y=2");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.scan("n=1 m=2", "n m sum"), "2 1 1");
}

TEST(InOut, ThatIsConstantTakesValues) {
  Sketch s;
  s.in(1, "n + 1");
  s.in(2, "Fixed");
  s.block(3, "Larger", "", "Larger=>sum", "x=1 y=2");
  s.block(4, "Larger", "", "Larger=>seen", "x:=5 y=3");
  s.in(5, "Row");
  s.block(6, "Total", "", "Total=>m", "v=5");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.codes(), "") << d.message();
  EXPECT_EQ(d.scan("n=5", "sum seen m"), "7 7 8");
  EXPECT_EQ(d.scan("n=9", "sum seen m"), "10 10 8");
  Sketch variable;
  variable.in(1, "list");
  variable.block(2, "Total", "", "Total=>sum", "v=1");
  Diagram itself(kVariables, variable, kOthers);
  EXPECT_EQ(itself.scan("list[1]=20 list[3]=1", "sum"), "21");
  EXPECT_EQ(itself.hidden().find("constant"), std::string::npos) << "a variable that is an array is not copied";
}

// ---- functions of several outputs, bounds -------------------------------------------------------------------------

TEST(Bundle, ComputesTheOutputsThatAreRead) {
  Sketch s;
  s.block(1, "SPLIT_DATE", "IN:=d", "YEAR=>sum MONTH DAY=>seen");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.count(Op::kCall), 2u) << d.listing();
  EXPECT_EQ(d.scan("d=86400000000000", "sum seen"), "1970 2");
}

TEST(ArrayBound, IsThatOfTheWiredArray) {
  Sketch s;
  s.in(1, "list");
  s.block(2, "UPPER_BOUND", "ARR=1 DIM:=1", "OUT=>sum");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.scan("", "sum"), "3");
}

// ---- DELAY --------------------------------------------------------------------------------------------------------

TEST(Delay, CarriesTheLastScan) {
  Sketch s;
  s.in(1, "n");
  s.block(2, "DELAY", "IN=1", "OUT");
  s.out(3, "sum", "2");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.over("n", "1 2 3", "sum"), "0 1 2");
}

TEST(Delay, TakesTheTypeOfItsReaderForALiteral) {
  Sketch s;
  s.in(1, "3");
  s.block(2, "DELAY", "IN=1", "OUT");
  s.out(3, "r", "2");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.scan("", "r"), "0");
  EXPECT_EQ(d.scan("", "r"), "3");
}

TEST(Delay, ModifiesWhatEntersAndWhatItBeganWith) {
  Sketch s;
  s.in(1, "A");
  s.block(2, "DELAY", "IN=1", "!OUT");
  s.out(3, "Y", "2");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.over("A", "1 1 0 0", "Y"), "1 0 0 1");
}

TEST(Delay, UnderEnKeepsWhatItHolds) {
  Sketch s;
  s.in(1, "A");
  s.in(2, "n");
  s.block(3, "DELAY", "EN=1 IN=2", "OUT ENO=>Y");
  s.out(4, "sum", "3.OUT");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.scan("A=1 n=5", "sum Y"), "0 1");
  EXPECT_EQ(d.scan("A=0 n=6", "sum Y"), "5 0");
  EXPECT_EQ(d.scan("A=1 n=7", "sum Y"), "5 1");
  EXPECT_EQ(d.scan("", "sum"), "7");
}

// ---- in-outs ------------------------------------------------------------------------------------------------------

TEST(InOut, PassesOnTheVariableThatIsWrittenAtItsPin) {
  Sketch s;
  s.block(1, "Flip flip", "", "", "v:=A");
  s.block(2, "Flip flip2", "", "", "v=1.v");
  s.block(3, "Bump bump", "step:=n", "", "IO:=sum");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.codes(), "") << d.message();
  EXPECT_EQ(d.scan("A=0 n=3", "A sum"), "0 3") << "turned twice";
}

// ---- what is reported ---------------------------------------------------------------------------------------------

struct Wrong {
  const char* name;
  void (*draw)(Sketch&);
  const char* codes;
  const char* words;
};

void PrintTo(const Wrong& wrong, std::ostream* out) { *out << wrong.name; }

class BlockReports : public testing::TestWithParam<Wrong> {};

TEST_P(BlockReports, WithCodeAndName) {
  Sketch s;
  s.in(1, "n");
  s.in(2, "r");
  GetParam().draw(s);
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.codes(), GetParam().codes) << d.message();
  EXPECT_NE(d.message().find(GetParam().words), std::string::npos) << d.message();
}

INSTANTIATE_TEST_SUITE_P(
    Blocks, BlockReports,
    testing::Values(Wrong{"WithoutInstance", [](Sketch& s) { s.block(3, "TON", "", "Q"); }, "P3009",
                          "TON has no instance name"},
                    Wrong{"InstanceOfAnotherType", [](Sketch& s) { s.block(3, "TOF t", "", "Q"); }, "P3024",
                          "block is a TOF, but \"t\" is declared as TON"},
                    Wrong{"UnknownInstance", [](Sketch& s) { s.block(3, "TON other", "", "Q"); }, "P4004",
                          "there is no variable \"other\""},
                    Wrong{"UnknownBlockIsSaidOnce",
                          [](Sketch& s) {
                            s.in(3, "whatever");
                            s.block(4, "Nothing x", "IN=3", "OUT");
                            s.block(5, "ADD", "IN1=4 IN2=1", "OUT");
                            s.out(6, "sum", "5");
                          },
                          "P3008", "block Nothing \"x\" is not known"},
                    Wrong{"InOutWithoutAWire", [](Sketch& s) { s.block(3, "Bump bump", "", "", "IO"); }, "P3012",
                          "in-out \"IO\" of Bump \"bump\" is not wired to a variable"},
                    Wrong{"InOutThatIsNotDrawn", [](Sketch& s) { s.block(3, "Bump bump", "", ""); }, "P3012",
                          "in-out \"IO\" of Bump \"bump\" is not drawn"},
                    Wrong{"InOutOnAnExpression",
                          [](Sketch& s) {
                            s.in(3, "n + 1");
                            s.block(4, "Bump bump", "", "", "IO=3");
                          },
                          "P3012", "is not wired to a variable"},
                    Wrong{"InOutOnAPart",
                          [](Sketch& s) {
                            s.in(3, "w.%B0");
                            s.block(4, "Bump bump", "", "", "IO=3");
                          },
                          "P3012", "is wired to a part of a variable"},
                    Wrong{"InOutThatIsNegated",
                          [](Sketch& s) {
                            s.in(3, "n");
                            s.block(4, "Bump bump", "", "", "!IO=3");
                          },
                          "P3012", "has a negation, an edge or a storage"},
                    Wrong{"InOutOnANegatedVariable",
                          [](Sketch& s) {
                            s.in(3, "!A");
                            s.block(4, "Flip flip", "", "", "v=3");
                          },
                          "P3012", "is wired to a variable with a negation, an edge or a storage"},
                    Wrong{"InOutBehindAnEdge",
                          [](Sketch& s) {
                            s.in(3, "A");
                            s.block(4, "Flip flip", "v=3", "^v");
                            s.block(5, "Flip flip2", "", "", "v=4.v");
                          },
                          "P3012", "in-out \"v\" of Flip \"flip2\" is wired to a variable with a negation"},
                    Wrong{"InOutOnAResultOfPinsWithoutNames",
                          [](Sketch& s) {
                            s.in(3, "A");
                            auto& block = s.block(4, "NOT", "", "");
                            test::BodyBuilder::feed(block, {3});
                            test::BodyBuilder::out(block, "");
                            s.block(5, "Flip flip", "", "", "v=4");
                          },
                          "P3012", "in-out \"v\" of Flip \"flip\" is not wired to a variable"},
                    Wrong{"WireAndTextAtOnePin",
                          [](Sketch& s) { s.block(3, "ADD", "IN1=1 IN2:=1", "OUT=>sum").inputs[0].expression = "5"; },
                          "P3013", "a wire and the text \"5\" meet at pin \"IN1\" of a block"},
                    Wrong{"ConstantInOutWithoutAWire", [](Sketch& s) { s.block(3, "Larger", "", "", "x=1 y"); },
                          "P3012", "is not wired"},
                    Wrong{"NegatedJumpWithoutAWire",
                          [](Sketch& s) {
                            s.jump(3, "over").negated = true;
                            s.label(4, "over");
                          },
                          "P3014", "jump has a negation, an edge or a storage, and is not connected"},
                    Wrong{"ReturnAtAnEdgeWithoutAWire", [](Sketch& s) { s.ret(3).edge = plcopen::Edge::kRising; },
                          "P3014", "return has a negation, an edge or a storage, and is not connected"},
                    Wrong{"InOutOfAnotherType", [](Sketch& s) { s.block(3, "Bump bump", "", "", "IO=2"); }, "P3007",
                          "has type INT, the variable wired to it has type REAL"},
                    Wrong{"InOutWiredToItself", [](Sketch& s) { s.block(3, "Bump bump", "", "", "IO=3.IO"); }, "P3012",
                          "is not wired to a variable"},
                    Wrong{"InputOfAnotherType", [](Sketch& s) { s.block(3, "Tank tank", "rate=2", ""); }, "P4101",
                          "input \"rate\" of Tank \"tank\""},
                    Wrong{"DelayWithoutInput", [](Sketch& s) { s.block(3, "DELAY", "IN", "OUT=>n"); }, "P3010",
                          "input of DELAY is not connected"},
                    Wrong{"DelayWithTwoInputs", [](Sketch& s) { s.block(3, "DELAY", "IN=1 IN2=1", "OUT=>n"); }, "P3011",
                          "DELAY has no input \"IN2\""},
                    Wrong{"NegatedNumberOfADelay", [](Sketch& s) { s.block(3, "DELAY", "IN=1", "!OUT=>n"); }, "P3023",
                          "output \"OUT\" of DELAY has a modifier but type INT"},
                    Wrong{"BundleWithoutInput", [](Sketch& s) { s.block(3, "SPLIT_DATE", "IN", "YEAR=>n"); }, "P3010",
                          "of SPLIT_DATE is not connected"},
                    Wrong{"BoundWithoutDimension", [](Sketch& s) { s.block(3, "LOWER_BOUND", "ARR=1", "OUT=>n"); },
                          "P3010", "LOWER_BOUND needs an array and the number of a dimension"},
                    Wrong{"NoSuchOverload", [](Sketch& s) { s.block(3, "SHL", "IN=2 N:=1", "OUT=>n"); }, "P4103",
                          "input \"IN\" of SHL has type REAL"}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(Missing, BlocksMayBeStubs) {
  Sketch s;
  s.in(1, "unknown_too");
  s.block(2, "Nothing x", "IN=1", "OUT");
  s.out(3, "sum", "2");
  s.in(4, "n");
  s.out(5, "seen", "4");
  Diagram d(kVariables, s, kOthers);
  d.options.stub_missing = true;
  EXPECT_EQ(d.codes(), "P3020");
  EXPECT_TRUE(d.pou().partial);
  EXPECT_EQ(d.scan("n=4 sum=9", "sum seen"), "9 4") << "what only a stub reads is not looked at, its reader keeps";
}

TEST(Memory, InAFunctionIsRefused) {
  const auto codes = [](const auto& draw) {
    Sketch function;
    draw(function);
    Sketch main;
    main.block(1, "Minus", "a:=n", "Minus=>sum");
    Diagram d(kVariables, main, kOthers);
    d.draw("Minus", function);
    return d.codes();
  };
  EXPECT_EQ(codes([](Sketch& s) {
              s.in(1, "^a > b");
              s.block(2, "SEL", "G=1 ^IN0=1 IN1:=FALSE", "OUT");
              s.in(3, "a");
              s.out(4, "Minus", "3");
            }),
            "P3026 P3026");
  EXPECT_EQ(codes([](Sketch& s) {
              s.block(1, "ADD", "IN1:=a IN2=1.OUT", "OUT");
              s.out(2, "Minus", "1");
            }),
            "P3026");
}

TEST(Delay, InAFunctionIsRefused) {
  Sketch function;
  function.in(1, "a");
  function.block(2, "DELAY", "IN=1", "OUT");
  function.out(3, "Minus", "2");
  Sketch main;
  main.block(1, "Minus", "a:=n", "Minus=>sum");
  Diagram d(kVariables, main, kOthers);
  d.draw("Minus", function);
  EXPECT_EQ(d.codes(), "P3026");
}

}  // namespace
}  // namespace plc
