// Variables, connectors, jumps and modifiers of a diagram: what reaches a variable, scan by scan; what cannot.
#include <gtest/gtest.h>

#include <string>

#include "tests/unit/frontend-fbd/diagram.h"

namespace plc {
namespace {

using ir::Op;
using test::Diagram;
using test::Sketch;

// ---- modifiers ----------------------------------------------------------------------------------------------------

struct Modified {
  const char* modifiers;
  const char* expected;
};

constexpr const char* kInputs = "0 1 1 0 0 1";

class Modifiers : public testing::TestWithParam<Modified> {};

TEST_P(Modifiers, OfAnInVariable) {
  Sketch s;
  s.in(1, std::string(GetParam().modifiers) + "A");
  s.out(2, "Y", "1");
  Diagram d("A, Y : BOOL;", s);
  EXPECT_EQ(d.over("A", kInputs, "Y"), GetParam().expected);
}

TEST_P(Modifiers, OfAnInputOfABlock) {
  Sketch s;
  s.in(1, "A");
  s.block(2, "OR", std::string(GetParam().modifiers) + "IN1=1 IN2:=FALSE", "OUT");
  s.out(3, "Y", "2");
  Diagram d("A, Y : BOOL;", s);
  EXPECT_EQ(d.over("A", kInputs, "Y"), GetParam().expected);
}

TEST_P(Modifiers, OfAnOutputOfABlock) {
  Sketch s;
  s.in(1, "A");
  s.block(2, "OR", "IN1=1 IN2:=FALSE", std::string(GetParam().modifiers) + "OUT=>X");
  s.out(3, "Y", "2.OUT");
  Diagram d("A, X, Y : BOOL;", s);
  EXPECT_EQ(d.over("A", kInputs, "Y"), GetParam().expected);
  EXPECT_EQ(d.read("X"), d.read("Y")) << "the variable at the pin has what the wire has";
}

TEST_P(Modifiers, OfAnInputText) {
  Sketch s;
  s.block(2, "OR", std::string(GetParam().modifiers) + "IN1:=A IN2:=FALSE", "OUT");
  s.out(3, "Y", "2");
  Diagram d("A, Y : BOOL;", s);
  EXPECT_EQ(d.over("A", kInputs, "Y"), GetParam().expected);
}

INSTANTIATE_TEST_SUITE_P(All, Modifiers,
                         testing::Values(Modified{"!", "1 0 0 1 1 0"}, Modified{"^", "0 1 0 0 0 1"},
                                         Modified{"~", "0 0 0 1 0 0"}, Modified{"!^", "1 0 0 1 0 0"},
                                         Modified{"!~", "0 1 0 0 0 1"}, Modified{"(S)", "0 1 1 1 1 1"},
                                         Modified{"(R)", "0 0 0 0 0 0"}, Modified{"!(S)", "1 1 1 1 1 1"}));

class OutVariables : public testing::TestWithParam<Modified> {};

// Storage of an outVariable writes into the variable itself, which began TRUE.
TEST_P(OutVariables, AreWrittenAsCoilsAre) {
  Sketch s;
  s.in(1, "A");
  s.out(2, std::string(GetParam().modifiers) + "Y", "1");
  Diagram d("A : BOOL; Y : BOOL := TRUE;", s);
  EXPECT_EQ(d.over("A", kInputs, "Y"), GetParam().expected);
}

INSTANTIATE_TEST_SUITE_P(All, OutVariables,
                         testing::Values(Modified{"", kInputs}, Modified{"!", "1 0 0 1 1 0"},
                                         Modified{"~", "0 0 0 1 0 0"}, Modified{"(S)", "1 1 1 1 1 1"},
                                         Modified{"(R)", "1 0 0 0 0 0"}, Modified{"~(R)", "1 1 1 0 0 0"}));

TEST(InOutVariable, HasModifiersOnBothSides) {
  Sketch s;
  s.in(1, "A");
  auto& both = s.in_out(2, "!V", "1");
  both.negated_out = true;
  both.edge_out = plcopen::Edge::kRising;
  s.out(3, "Y", "2");
  Diagram d("A, V, Y : BOOL;", s);
  EXPECT_EQ(d.scan("A=1", "V Y"), "0 1");
  EXPECT_EQ(d.scan("A=1", "V Y"), "0 0") << "NOT V stays TRUE: no edge";
  EXPECT_EQ(d.scan("A=0", "V Y"), "1 0");
  EXPECT_EQ(d.scan("A=1", "V Y"), "0 1");
}

TEST(InOutVariable, WithoutAWireIsReadOnly) {
  Sketch s;
  s.in_out(1, "V");
  s.out(2, "Y", "1");
  Diagram d("V, Y : INT;", s);
  EXPECT_EQ(d.scan("V=5", "V Y"), "5 5");
  EXPECT_EQ(d.count(Op::kStore), 1u);
}

TEST(InOutVariable, PassesOnWhatItHoldsNotWhatItGot) {
  Sketch s;
  s.in(1, "small");
  s.in_out(2, "limited", "1");
  s.out(3, "Y", "2");
  Diagram d("small, Y : INT; limited : INT (0..10);", s);
  EXPECT_EQ(d.scan("small=50", "limited Y"), "10 10");
}

// ---- outVariables -------------------------------------------------------------------------------------------------

TEST(OutVariable, WidensWhatArrives) {
  Sketch s;
  s.in(1, "n");
  s.out(2, "Y", "1");
  s.in(3, "7");
  s.out(4, "Z", "3");
  Diagram d("n : INT; Y : REAL; Z : LINT;", s);
  EXPECT_EQ(d.scan("n=-3", "Y Z"), "-3 7");
}

TEST(OutVariable, PassesOnWhatArrivedWithoutItsOwnModifier) {
  Sketch s;
  s.in(1, "A");
  s.out(2, "!X", "1");
  s.out(3, "Y", "2");
  Diagram d("A, X, Y : BOOL;", s);
  EXPECT_EQ(d.scan("A=1", "X Y"), "0 1");
}

TEST(OutVariable, WithoutATextOnlyPassesOn) {
  Sketch s;
  s.in(1, "n");
  s.out(2, "", "1");
  s.out(3, "Y", "2");
  Diagram d("n, Y : INT;", s);
  EXPECT_EQ(d.scan("n=4", "Y"), "4");
}

TEST(Wires, ThatMeetAreOrOfBool) {
  Sketch s;
  s.in(1, "A");
  s.in(2, "B");
  s.out(3, "Y", "1|2");
  Diagram d("A, B, Y : BOOL;", s);
  EXPECT_EQ(d.scan("A=0 B=1", "Y"), "1");
  EXPECT_EQ(d.scan("B=0", "Y"), "0");
}

TEST(Wires, CarryOneValueForAllReaders) {
  Sketch s;
  s.in(1, "n");
  s.block(2, "ADD", "IN1=1 IN2:=1", "OUT=>n");
  s.out(3, "Y", "1");
  Diagram d("n, Y : INT;", s);
  EXPECT_EQ(d.scan("n=4", "n Y"), "5 4") << "n was read for the block";
}

// ---- variables at outputs -----------------------------------------------------------------------------------------

TEST(Targets, StandAtVariablesToo) {
  Sketch s;
  auto& in = s.in(1, "n");
  auto& pin = test::BodyBuilder::out(in, "");
  pin.target = "copy";
  pin.target_at = in.at;
  Diagram d("n, copy : INT;", s);
  EXPECT_EQ(d.scan("n=8", "copy"), "8");
}

TEST(Targets, AtAnEnoAreWrittenAlways) {
  Sketch s;
  s.in(1, "A");
  s.block(2, "ADD", "EN=1 IN1:=n IN2:=1", "ENO=>good OUT=>sum");
  Diagram d("A, good : BOOL; n, sum : INT;", s);
  EXPECT_EQ(d.scan("A=1 n=4", "good sum"), "1 5");
  EXPECT_EQ(d.scan("A=0 n=9", "good sum"), "0 5");
}

TEST(Targets, OfALeftSideAreNotWrittenTwice) {
  Sketch s;
  s.in(1, "v");
  s.block(2, "Bump b", "", "IO=>v", "IO=1");
  Diagram d("v : INT; b : Bump;", s,
            "FUNCTION_BLOCK Bump VAR_IN_OUT IO : INT; END_VAR IO := IO + 1; END_FUNCTION_BLOCK");
  EXPECT_EQ(d.scan("v=4", "v"), "5");
  EXPECT_EQ(d.count(Op::kStore), 1u) << "the reference alone\n" << d.listing();
}

// ---- connectors, jumps --------------------------------------------------------------------------------------------

TEST(Connector, CarriesValuesAndWhetherTheirBlockRan) {
  Sketch s;
  s.in(1, "A");
  s.block(2, "ADD", "EN=1 IN1:=n IN2:=1", "OUT");
  s.connector(3, "K", "2.OUT");
  s.continuation(4, "K");
  s.out(5, "Y", "4");
  s.continuation(6, "k");
  s.out(7, "Z", "6");
  Diagram d("A : BOOL; n, Y, Z : INT;", s);
  EXPECT_EQ(d.scan("A=1 n=4", "Y Z"), "5 5");
  EXPECT_EQ(d.scan("A=0", "Y Z"), "5 5") << "not written, as without the connector";
}

TEST(Connector, CarriesLiteralsThatTakeTheirTypeAtTheEnd) {
  Sketch s;
  s.in(1, "300");
  s.connector(2, "K", "1");
  s.continuation(3, "K");
  s.out(4, "Y", "3");
  s.out(5, "Z", "3");
  Diagram d("Y : UINT; Z : LREAL;", s);
  EXPECT_EQ(d.scan("", "Y Z"), "300 300");
}

TEST(Jump, OfADiagramTakesItsConditionFromAWire) {
  Sketch s;
  s.in(1, "!A");
  s.jump(2, "L", "1");
  s.in(3, "1");
  s.out(4, "Y", "3");
  s.label(5, "L");
  s.in(6, "2");
  s.out(7, "Z", "6");
  Diagram d("A : BOOL; Y, Z : INT;", s);
  EXPECT_EQ(d.scan("A=0", "Y Z"), "0 2");
  EXPECT_EQ(d.scan("A=1", "Y Z"), "1 2");
}

TEST(Jump, AndReturnMayBeNegated) {
  Sketch s;
  s.in(1, "A");
  s.jump(2, "L", "1").negated = true;
  s.in(3, "1");
  s.out(4, "Y", "3");
  s.label(5, "L");
  s.in(6, "A");
  s.ret(7, "6").negated = true;
  s.in(8, "2");
  s.out(9, "Z", "8");
  Diagram d("A : BOOL; Y, Z : INT;", s);
  EXPECT_EQ(d.scan("A=0", "Y Z"), "0 0");
  EXPECT_EQ(d.scan("A=1", "Y Z"), "1 2");
}

// ---- what is reported ---------------------------------------------------------------------------------------------

struct Wrong {
  const char* name;
  void (*draw)(Sketch&);
  const char* codes;
  const char* words;
};

void PrintTo(const Wrong& wrong, std::ostream* out) { *out << wrong.name; }

class VariableReports : public testing::TestWithParam<Wrong> {};

TEST_P(VariableReports, WithCodeAndName) {
  Sketch s;
  s.in(1, "n");
  s.in(2, "A");
  GetParam().draw(s);
  Diagram d("A, B, Y : BOOL; n, m : INT; r : REAL; v : STRING;", s);
  EXPECT_EQ(d.codes(), GetParam().codes) << d.message();
  EXPECT_NE(d.message().find(GetParam().words), std::string::npos) << d.message();
}

INSTANTIATE_TEST_SUITE_P(
    Variables, VariableReports,
    testing::Values(Wrong{"OutVariableWithoutWire", [](Sketch& s) { s.out(3, "Y", ""); }, "P3022",
                          "outVariable \"Y\" is not connected"},
                    Wrong{"NothingAtAll", [](Sketch& s) { s.out(3, "", ""); }, "", ""},
                    Wrong{"ConnectorWithoutWire",
                          [](Sketch& s) {
                            s.connector(3, "K", "");
                            s.continuation(4, "K");
                            s.out(5, "Y", "4");
                          },
                          "P3014", "connector \"K\" is not connected"},
                    Wrong{"NumbersThatMeet", [](Sketch& s) { s.out(3, "m", "1|2|1"); }, "P3013",
                          "one of them has type INT"},
                    Wrong{"ModifierOnANumber", [](Sketch& s) { s.out(3, "!m", "1"); }, "P3023",
                          "outVariable \"m\" has a modifier but type INT"},
                    Wrong{"ModifierOnAnInOutVariable", [](Sketch& s) { s.in_out(3, "(S)m", "1"); }, "P3023",
                          "inOutVariable \"m\" has a modifier but type INT"},
                    Wrong{"NegatedNumber",
                          [](Sketch& s) {
                            s.in(3, "!m");
                            s.out(4, "Y", "3");
                          },
                          "P3023", "inVariable \"m\" has a modifier but type INT"},
                    Wrong{"EdgeOfANumberAtAPin",
                          [](Sketch& s) {
                            s.block(3, "ADD", "^IN1=1 IN2:=1", "OUT");
                            s.out(4, "m", "3");
                          },
                          "P3023", "pin \"IN1\" has a modifier but type INT"},
                    Wrong{"ModifierOnAResult",
                          [](Sketch& s) {
                            s.block(3, "ADD", "IN1=1 IN2:=1", "!OUT");
                            s.out(4, "m", "3");
                          },
                          "P3023", "output \"OUT\" of ADD has a modifier but type INT"},
                    Wrong{"TextIntoANumber",
                          [](Sketch& s) {
                            s.in(3, "v");
                            s.out(4, "m", "3");
                          },
                          "P4101", "outVariable \"m\""},
                    Wrong{"UnknownNameIsSaidOnce",
                          [](Sketch& s) {
                            s.in(3, "nothing");
                            s.out(4, "m", "3");
                            s.block(5, "ADD", "IN1=3 IN2=1", "OUT");
                            s.out(6, "r", "5");
                          },
                          "P4004", "there is no variable \"nothing\""},
                    Wrong{"TargetAtAJump",
                          [](Sketch& s) {
                            auto& jump = s.jump(3, "L", "2");
                            test::BodyBuilder::out(jump, "").target = "B";
                            s.label(4, "L");
                          },
                          "P3003", "variable \"B\" is drawn at the output of a jump, which has none"},
                    Wrong{"NegatedEdgeAtAPin",
                          [](Sketch& s) {
                            s.block(3, "OR", "!^IN1=2 IN2:=B", "OUT");
                            s.out(4, "Y", "3");
                          },
                          "P3027", "pin \"IN1\" of OR has negation and a rising edge"},
                    Wrong{"ContactsAreOfTheLadder", [](Sketch& s) { s.contact(3, "A", "2"); }, "P9001", "contact"}),
    [](const auto& row) { return std::string(row.param.name); });

}  // namespace
}  // namespace plc
