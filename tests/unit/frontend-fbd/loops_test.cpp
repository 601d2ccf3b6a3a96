// Loops and the types on wires: which wire is a scan old by each rule, what memory it takes, and what type a loop or a
// literal has where only its neighbours tell.
#include "frontend-fbd/loops.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/unit/frontend-fbd/diagram.h"

namespace plc {
namespace {

using test::Diagram;
using test::Sketch;

constexpr const char* kVariables =
    "A, B, X, Y : BOOL; n, m : INT; big : DINT; r : REAL; lr : LREAL; u : UINT; c : CTU; t : TON; mixed : Mixed; "
    "raised : Raise; many : ARRAY [1..2] OF Raise;";
constexpr const char* kOthers =
    "FUNCTION_BLOCK Raise VAR_INPUT x : INT; END_VAR VAR_OUTPUT q : INT := 5; END_VAR q := x + 1; END_FUNCTION_BLOCK\n"
    "VAR_GLOBAL global_raised : Raise; END_VAR\n"
    "FUNCTION_BLOCK Mixed VAR_INPUT x : LREAL; END_VAR VAR_OUTPUT y : LREAL; END_VAR y := x; END_FUNCTION_BLOCK\n"
    "FUNCTION Half : REAL VAR_INPUT x : REAL; END_VAR Half := x / 2.0; END_FUNCTION\n";

// ---- values on loops ----------------------------------------------------------------------------------------------

TEST(Feedback, OfABlockOnItselfCountsScans) {
  Sketch s;
  s.block(1, "ADD", "IN1=1 IN2:=1", "OUT");
  s.out(2, "n", "1");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.codes(), "");
  EXPECT_EQ(d.scan("", "n"), "1");
  EXPECT_EQ(d.scan("", "n"), "2");
  EXPECT_EQ(d.scan("n=50", "n"), "3") << "the wire has its own memory";
}

TEST(Feedback, OfAnInstanceReadsItsOutput) {
  Sketch s;
  s.block(1, "CTU c", "CU:=A RESET=1.Q PV:=2", "Q CV=>n");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.over("A", "1 0 1 0 1", "n"), "1 1 2 0 1");
  EXPECT_EQ(d.hidden(), "") << "an output of an instance is memory";
}

TEST(Feedback, OfANegatedOutputNeedsAMemory) {
  Sketch s;
  s.block(1, "TON t", "IN=1.Q PT:=T#10ms", "!Q");
  Diagram d(kVariables, s, kOthers);
  EXPECT_NE(d.hidden().find("feedback.1"), std::string::npos) << d.hidden();
  EXPECT_EQ(d.scan("", "t.IN t.Q"), "1 0") << "before the first scan the wire is the opposite of what Q begins with";
  EXPECT_EQ(d.scan("", "t.IN t.Q"), "1 1");
  EXPECT_EQ(d.scan("", "t.IN t.Q"), "0 0");
}

TEST(Feedback, BeginsWithWhatTheOutputBeginsWith) {
  for (const char* type : {"Raise raised", "Raise many[2]", "Raise global_raised"}) {
    Sketch s;
    s.block(1, type, "x=1.q", "q=>n");
    Diagram d(kVariables, s, kOthers);
    EXPECT_EQ(d.codes(), "") << type;
    EXPECT_EQ(d.scan("", "n"), "6") << type;
    EXPECT_EQ(d.scan("", "n"), "7") << type;
  }
}

TEST(Feedback, OfANegatedResultBeginsTrue) {
  Sketch s;
  s.block(1, "AND", "IN1:=A IN2=1.OUT", "!OUT=>Y");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.over("A", "1 1 1 0 1", "Y"), "0 1 0 1 0");
}

TEST(Feedback, OfAFunctionUnderEnBeginsAtItsDefaultAgain) {
  Sketch s;
  s.in(1, "A");
  s.block(2, "ADD", "EN=1 IN1=2.OUT IN2:=1", "OUT=>n");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.over("A", "1 1 0 1", "n"), "1 2 2 1");
}

TEST(Feedback, ThroughAnInOutVariableIsTheVariable) {
  Sketch s;
  s.block(1, "ADD", "IN1=2 IN2:=1", "OUT");
  s.in_out(2, "n", "1");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.scan("n=5", "n"), "6");
  EXPECT_EQ(d.scan("", "n"), "7");
  EXPECT_EQ(d.hidden(), "");
}

TEST(Feedback, ThroughAnInOutVariableIsNegatedOnItsWayOut) {
  Sketch s;
  s.block(1, "OR", "IN1=2 IN2:=FALSE", "OUT");
  s.in_out(2, "Y", "1").negated_out = true;
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.scan("", "Y"), "1");
  EXPECT_EQ(d.scan("", "Y"), "0");
  EXPECT_EQ(d.scan("", "Y"), "1");
}

// A latch of two gates: which wire is old decides what both inputs together do.
Sketch latch(bool set_above) {
  Sketch s;
  s.block(1, "OR", "IN1:=A IN2=2", "OUT").y = set_above ? 10 : 90;
  s.block(2, "AND", "IN1=1 !IN2:=B", "OUT").y = 50;
  s.out(3, "X", "1");
  s.out(4, "Y", "2");
  return s;
}

TEST(Feedback, LeadsIntoTheUpperElementOfALoop) {
  Diagram above(kVariables, latch(true), kOthers);
  EXPECT_NE(above.hidden().find("feedback.2"), std::string::npos) << above.hidden();
  EXPECT_EQ(above.scan("A=1", "X Y"), "1 1");
  EXPECT_EQ(above.scan("A=0", "X Y"), "1 1");
  EXPECT_EQ(above.scan("B=1", "X Y"), "1 0");
  Diagram below(kVariables, latch(false), kOthers);
  EXPECT_NE(below.hidden().find("feedback.1"), std::string::npos) << below.hidden();
  EXPECT_EQ(below.scan("A=1", "X Y"), "1 0") << "AND sees the OR of the last scan";
  EXPECT_EQ(below.scan("A=0", "X Y"), "1 1");
}

TEST(Feedback, LeadsByTheOrderOfTheFileWhereThatIsAskedFor) {
  Diagram d(kVariables, latch(false), kOthers);
  d.options.order = core::Order::kDocument;
  // OR, first in the file, pulls the AND in front of it, which reads OR as it was.
  EXPECT_EQ(d.scan("A=1", "X Y"), "1 0");
  EXPECT_EQ(d.scan("A=0", "X Y"), "1 1");
}

TEST(Feedback, IsOpenedByADelayWithoutAnyOther) {
  Sketch s;
  s.block(1, "ADD", "IN1=2 IN2:=1", "OUT");
  s.block(2, "DELAY", "IN=1", "OUT");
  s.out(3, "n", "1");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.scan("", "n"), "1");
  EXPECT_EQ(d.scan("", "n"), "2");
  EXPECT_EQ(d.hidden().find(' '), std::string::npos) << "one memory for the register and the wire: " << d.hidden();
}

TEST(Feedback, FromALaterElementWithAnIdIsAScanOld) {
  Sketch s;
  s.in(1, "n");
  s.block(2, "ADD", "IN1=1 IN2=3", "OUT=>m").execution_order = 1;
  s.block(3, "MOVE", "IN=1", "OUT").execution_order = 2;
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.over("n", "1 2 3", "m"), "1 3 5");
}

// ---- types on wires -----------------------------------------------------------------------------------------------

struct Types {
  const char* name;
  void (*draw)(Sketch&);
  const char* read;
  const char* values;  ///< after two scans
};

void PrintTo(const Types& types, std::ostream* out) { *out << types.name; }

class TypesOnWires : public testing::TestWithParam<Types> {};

TEST_P(TypesOnWires, AreTold) {
  Sketch s;
  GetParam().draw(s);
  Diagram d(kVariables, s, kOthers);
  ASSERT_EQ(d.codes(), "") << d.message();
  d.scan("n=3 big=100000 r=0.5", "");
  EXPECT_EQ(d.scan("", GetParam().read), GetParam().values);
}

INSTANTIATE_TEST_SUITE_P(Wires, TypesOnWires,
                         testing::Values(Types{"LoopByWhatFeedsIt",
                                               [](Sketch& s) {
                                                 s.in(1, "n");
                                                 s.block(2, "ADD", "IN1=2 IN2=1", "OUT");
                                                 s.out(3, "big", "2");
                                               },
                                               "big", "6"},
                                         Types{"LoopByTheWidestThatFeedsIt",
                                               [](Sketch& s) {
                                                 s.in(1, "n");
                                                 s.in(4, "big");
                                                 s.block(2, "ADD", "IN1=2 IN2=1 IN3=4", "OUT=>lr");
                                               },
                                               "lr", "200006"},
                                         Types{"LoopOfLiteralsByItsReader",
                                               [](Sketch& s) {
                                                 s.block(1, "ADD", "IN1=1 IN2:=1", "OUT");
                                                 s.out(2, "r", "1");
                                               },
                                               "r", "2"},
                                         Types{"LoopThroughAFunctionOfTheProject",
                                               [](Sketch& s) {
                                                 s.block(1, "Half", "x=2", "Half");
                                                 s.block(2, "ADD", "IN1=1 IN2:=8.0", "OUT=>r");
                                               },
                                               "r", "12"},
                                         Types{"LoopThroughAConnector",
                                               [](Sketch& s) {
                                                 s.continuation(1, "K");
                                                 s.block(2, "ADD", "IN1=1 IN2:=n", "OUT=>m");
                                                 s.connector(3, "K", "2");
                                               },
                                               "m", "6"},
                                         Types{"LiteralsByTheVariableAfterTheBlock",
                                               [](Sketch& s) {
                                                 s.block(1, "ADD", "IN1:=1 IN2:=2", "OUT");
                                                 s.out(2, "r", "1");
                                               },
                                               "r", "3"},
                                         Types{"LiteralsByTheBlockAfterTheBlock",
                                               [](Sketch& s) {
                                                 s.block(1, "ADD", "IN1:=70000 IN2:=2", "OUT");
                                                 s.block(2, "SUB", "IN1=1 IN2:=1", "OUT");
                                                 s.block(3, "Mixed mixed", "x=2", "y=>lr");
                                               },
                                               "lr", "70001"},
                                         Types{"LiteralsByAVariableAtThePin",
                                               [](Sketch& s) { s.block(1, "ADD", "IN1:=70000 IN2:=2", "OUT=>big"); },
                                               "big", "70002"},
                                         Types{"ExpressionsByTheirReader",
                                               [](Sketch& s) {
                                                 s.in(1, "40000 * 2");
                                                 s.out(2, "big", "1");
                                                 s.in(3, "1.0 / 3");
                                                 s.out(4, "r", "3");
                                                 s.in(5, "1.0 / 3");
                                                 s.out(6, "lr", "5");
                                               },
                                               "big r lr", "80000 0.33333334 0.3333333333333333"}),
                         [](const auto& row) { return std::string(row.param.name); });

TEST(TypesOnWires, ThatNobodyTellsAreReported) {
  Sketch s;
  s.block(1, "MOVE", "IN=2", "OUT");
  s.block(2, "MOVE", "IN=1", "OUT");
  Diagram d(kVariables, s, kOthers);
  EXPECT_EQ(d.codes(), "P3007");
  EXPECT_NE(d.message().find("type of the feedback wire from \"MOVE\" cannot be told | give the loop a variable"),
            std::string::npos)
      << d.message();
}

// Loops that cross: the paths back double with every block, the questions do not.
TEST(TypesOnWires, OfCrossingLoopsAreAskedForInBounds) {
  Sketch s;
  constexpr int kBlocks = 40;
  for (int i = 1; i <= kBlocks; ++i) {
    const int next = i == kBlocks ? 1 : i + 1, after = next == kBlocks ? 1 : next + 1;
    s.block(i, "MAX", "IN1=" + std::to_string(next) + " IN2=" + std::to_string(after), "OUT");
  }
  s.block(99, "MAX", "IN1=1 IN2:=n", "OUT=>m");
  Diagram d(kVariables, s, kOthers);
  d.codes();
  EXPECT_LE(d.diagnostics.error_count(), static_cast<std::size_t>(kBlocks) * 2);
}

// ---- Loops, on graphs ---------------------------------------------------------------------------------------------

TEST(Loops, AreHeldByBlocksAndInOutVariables) {
  plcopen::Element e;
  for (const auto& [kind, holds] : {std::pair(core::ElementKind::kBlock, true),
                                    {core::ElementKind::kInOutVariable, true},
                                    {core::ElementKind::kOutVariable, false},
                                    {core::ElementKind::kContact, false},
                                    {core::ElementKind::kCoil, false},
                                    {core::ElementKind::kConnector, false}}) {
    e.kind = kind;
    EXPECT_EQ(fbd::can_hold(e), holds) << core::element_word(kind);
  }
}

/// Opens the loops of all nodes; which wires became feedback, "from>to".
std::string opened(const Sketch& sketch, std::size_t* reports = nullptr) {
  const plcopen::Body body = sketch.body();
  core::Diagnostics diagnostics;
  fbd::Graph graph = fbd::build_graph(body, "P", diagnostics);
  const std::vector<bool> none(graph.nodes.size(), false);
  std::vector<bool> waits;
  std::vector<fbd::PlaceKey> keys;
  std::vector<fbd::NodeId> all;
  for (fbd::NodeId n = 0; n < graph.nodes.size(); ++n) {
    all.push_back(n);
    waits.push_back(fbd::only_passes_on(graph, n));
    keys.emplace_back(graph.element(n).y, graph.element(n).x, n);
  }
  std::size_t count = 0;
  fbd::Loops({graph, none, waits, keys, [&](fbd::NodeId) { ++count; }}).open(all);
  if (reports != nullptr) *reports = count;
  std::string text;
  for (const fbd::NodeId n : all) {
    for (const fbd::Wire& wire : graph.wires_into(n)) {
      if (!wire.feedback) continue;
      text += (text.empty() ? "" : " ") + std::to_string(graph.element(wire.from.node).at.local_id) + ">" +
              std::to_string(graph.element(n).at.local_id);
    }
  }
  return text;
}

TEST(Loops, AreOpenedInFrontOfTheirFirstElement) {
  Sketch s;
  s.block(1, "B", "a=3", "o");
  s.block(2, "B", "a=1", "o");
  s.block(3, "B", "a=2", "o");
  EXPECT_EQ(opened(s), "3>1");
}

TEST(Loops, InsideLoopsAreOpenedToo) {
  Sketch s;
  s.block(1, "B", "a=4", "o");
  s.block(2, "B", "a=1 b=3", "o");
  s.block(3, "B", "a=2", "o");
  s.block(4, "B", "a=3", "o");
  EXPECT_EQ(opened(s), "4>1 3>2");
}

TEST(Loops, AreOpenedAfterContactsWherePowerComesFromABlock) {
  Sketch s;
  s.contact(1, "A", "4");
  s.contact(2, "B", "1");
  s.block(3, "B", "a=2", "o");
  s.block(4, "B", "a=3", "o");
  EXPECT_EQ(opened(s), "4>1") << "the contacts are read in this scan";
}

TEST(Loops, AreOpenedAtAnInOutVariableFirst) {
  Sketch s;
  s.block(1, "B", "a=3", "o");
  s.block(2, "B", "a=1", "o");
  s.in_out(3, "v", "2");
  s.block(4, "B", "a=3", "o");
  EXPECT_EQ(opened(s), "3>1");
  Sketch below;
  below.block(1, "B", "a=2", "o");
  below.block(2, "B", "a=3", "o");
  below.in_out(3, "v", "1");
  EXPECT_EQ(opened(below), "3>2") << "its first reader, not the first element of the loop";
}

TEST(Loops, ThatHoldNothingAreReportedOnce) {
  Sketch s;
  s.contact(1, "A", "2");
  s.contact(2, "B", "1|3");
  s.contact(3, "C", "2");
  std::size_t reports = 0;
  EXPECT_EQ(opened(s, &reports), "2>1 1>2 3>2 2>3");
  EXPECT_EQ(reports, 1u);
}

TEST(Loops, LeaveWiresThatAreOnNoneAlone) {
  Sketch s;
  s.in(1, "n");
  s.block(2, "B", "a=1", "o");
  s.block(3, "B", "a=2 b=3", "o");
  s.out(4, "m", "3");
  EXPECT_EQ(opened(s), "3>3");
}

}  // namespace
}  // namespace plc
