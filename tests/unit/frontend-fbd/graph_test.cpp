// Where wires lead from: outputs by name, by type and by what the reader asks for; connectors; what an export leaves
// out; what dangles; the EN that a closed branch gives its boxes.
#include "frontend-fbd/graph.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/unit/frontend-fbd/diagram.h"

namespace plc {
namespace {

using fbd::OutRef;
using test::BodyBuilder;
using test::Diagram;
using test::Sketch;

/// A graph with the body that it points into; without the types of blocks unless a diagram lends them.
struct Built {
  plcopen::Body body;
  core::Diagnostics diagnostics;
  fbd::Graph graph;

  explicit Built(plcopen::Body drawn) : body(std::move(drawn)) { graph = fbd::build_graph(body, "P", diagnostics); }
  Built(plcopen::Body drawn, Diagram& d) : body(std::move(drawn)) {
    d.pou();
    ir::Builder builder(*d.module, 0, d.diagnostics);
    graph = fbd::build_graph(body, "P", diagnostics, &builder);
  }

  [[nodiscard]] std::string codes() const {
    std::string codes;
    for (const core::Diagnostic& d : diagnostics.all()) {
      codes += (codes.empty() ? "" : " ") + std::string(core::info(d.code).name);
    }
    return codes;
  }
  /// Where the wires into an element lead from: "IN1=2.OUT,3 EN=4.ENO".
  [[nodiscard]] std::string into(std::int64_t id) const {
    std::string text;
    for (const fbd::Node& node : graph.nodes) {
      if (node.element->at.local_id != id) continue;
      for (std::uint32_t i = node.first_input; i < node.first_input + node.input_count; ++i) {
        const fbd::Input& input = graph.inputs[i];
        text += (text.empty() ? "" : " ") + std::string(input.pin->negated ? "!" : "") + input.pin->name + "=";
        for (std::uint32_t w = 0; w < input.wire_count; ++w) {
          const OutRef& from = graph.wires[input.first_wire + w].from;
          const plcopen::Element& e = graph.element(from.node);
          text += (w == 0 ? "" : ",") + std::to_string(e.at.local_id);
          if (from.kind == OutRef::Kind::kPin) text += "." + e.outputs[from.pin].name;
          if (from.kind == OutRef::Kind::kInOut) text += "." + e.in_outs[from.pin].name + "(in-out)";
          if (from.kind == OutRef::Kind::kEno) text += ".ENO";
        }
      }
    }
    return text;
  }
};

// ---- outputs of blocks --------------------------------------------------------------------------------------------

TEST(Graph, WiresLeaveTheOutputTheyNameInAnyCase) {
  Sketch s;
  s.block(1, "CTU c", "", "Q CV ENO");
  s.out(2, "a", "1.cv");
  s.out(3, "b", "1.Q");
  s.out(4, "c", "1.eno");
  const Built g(s.body());
  EXPECT_EQ(g.into(2), "=1.CV");
  EXPECT_EQ(g.into(3), "=1.Q");
  EXPECT_EQ(g.into(4), "=1.ENO");
  EXPECT_EQ(g.codes(), "");
}

TEST(Graph, TheRightSideOfAnInOutIsAnOutputOfItsOwn) {
  Sketch s;
  s.in(1, "v");
  s.block(2, "Fb f", "", "Q", "IO=1");
  s.out(3, "w", "2.IO");
  const Built g(s.body());
  EXPECT_EQ(g.into(2), "IO=1");
  EXPECT_EQ(g.into(3), "=2.IO(in-out)");
}

TEST(Graph, AWireWithoutANameLeavesTheOnlyOutput) {
  Sketch s;
  s.block(1, "ADD", "", "OUT ENO");
  s.out(2, "a", "1");
  s.block(3, "ADD", "EN=1 IN1=1", "OUT");
  s.contact(4, "A", "1");
  const Built g(s.body());
  EXPECT_EQ(g.into(2), "=1.OUT");
  EXPECT_EQ(g.into(3), "EN=1.ENO IN1=1.OUT") << "EN asks for power";
  EXPECT_EQ(g.into(4), "=1.ENO") << "and so does a contact";
  EXPECT_EQ(g.codes(), "");
}

TEST(Graph, AWireWithoutANameFromSeveralOutputsIsSaidToBeOpen) {
  Sketch s;
  s.block(1, "CTU c", "", "Q CV");
  s.out(2, "a", "1");
  s.block(3, "CTU d", "", "ENO Q CV");
  s.coil(4, "b", "3");
  const Built g(s.body());
  EXPECT_EQ(g.into(2), "=1.Q");
  EXPECT_EQ(g.into(4), "=3.ENO");
  EXPECT_EQ(g.codes(), "P3002 P3002");
}

TEST(Graph, WithoutTypesAForeignNameIsTheOnlyOutput) {
  Sketch s;
  s.block(1, "Fb f", "", "Q");
  s.out(2, "a", "1.other");
  s.block(3, "Fb g", "", "Q R");
  s.out(4, "b", "3.other");
  const Built g(s.body());
  EXPECT_EQ(g.into(2), "=1.Q");
  EXPECT_EQ(g.into(4), "=3.Q");
  EXPECT_EQ(g.codes(), "P3002") << "of several outputs any may be meant";
}

TEST(Graph, WithTypesAForeignNameOfABlockWithSeveralOutputsIsReported) {
  Sketch s;
  s.block(1, "CTU c", "", "Q");
  s.out(2, "a", "1.other");
  Diagram types("c : CTU;", Sketch());
  const Built g(s.body(), types);
  EXPECT_EQ(g.into(2), "=1.Q");
  EXPECT_EQ(g.codes(), "P3002");
}

TEST(Graph, PowerOfABlockWithoutEnoIsItsFirstBoolOutput) {
  Sketch s;
  s.block(1, "Pair f", "", "n done");
  s.coil(2, "a", "1");
  s.out(3, "m", "1");
  Diagram types("f : Pair;", Sketch(),
                "FUNCTION_BLOCK Pair VAR_OUTPUT n : INT; done : BOOL; END_VAR n := 1; END_FUNCTION_BLOCK");
  const Built g(s.body(), types);
  EXPECT_EQ(g.into(2), "=1.done");
  EXPECT_EQ(g.into(3), "=1.n");
  EXPECT_EQ(g.codes(), "P3002 P3002");
}

// ---- what the file leaves out -------------------------------------------------------------------------------------

TEST(Graph, PinsThatAreNotListedComeFromTheType) {
  Sketch s;
  s.block(1, "CTU c", "", "");
  s.out(2, "a", "1.CV");
  s.block(3, "TON t", "", "Q");
  s.out(4, "b", "3.ET");
  s.block(5, "ABS", "IN:=n", "");
  s.out(6, "d", "5");
  Diagram types("c : CTU; t : TON; n : INT;", Sketch());
  const Built g(s.body(), types);
  EXPECT_EQ(g.into(2), "=1.CV");
  EXPECT_EQ(g.into(4), "=3.ET");
  EXPECT_EQ(g.into(6), "=5.ABS");
  EXPECT_EQ(g.codes(), "");
  EXPECT_EQ(g.graph.element(0).outputs.size(), 2u);
  EXPECT_TRUE(g.body.elements[0].outputs.empty()) << "the body stays as it was drawn";
}

TEST(Graph, TheResultOfAFunctionHasManyNames) {
  for (const char* name : {"OUT", "Twice", "twice"}) {
    Sketch s;
    s.block(1, "Twice", "x:=n", "Result more");
    s.out(2, "a", std::string("1.") + name);
    Diagram types("n : INT;", Sketch(),
                  "FUNCTION Twice : INT VAR_INPUT x : INT; END_VAR VAR_OUTPUT more : INT; END_VAR END_FUNCTION");
    const Built g(s.body(), types);
    EXPECT_EQ(g.into(2), "=1.Result") << name;
    EXPECT_EQ(g.codes(), "") << name;
  }
}

TEST(Graph, ANamespaceBeforeATypeIsDropped) {
  Sketch s;
  s.block(1, "Standard.TON t", "", "Q");
  s.block(2, "t.Something", "", "");
  s.block(3, "Other.Unknown u", "", "");
  Diagram types("t : TON;", Sketch());
  const Built g(s.body(), types);
  EXPECT_EQ(g.graph.element(0).text, "TON");
  EXPECT_EQ(g.graph.element(1).text, "t.Something");
  EXPECT_EQ(g.graph.element(2).text, "Other.Unknown");
}

// ---- wires that lead from nowhere ---------------------------------------------------------------------------------

TEST(Graph, WiresFromNothingAreLeftOut) {
  Sketch s;
  s.out(1, "a", "77");
  s.right_rail(2, "");
  s.jump(3, "L");
  s.label(4, "L");
  s.ret(5);
  s.in(6, "n");
  s.out(7, "b", "2|3|4|5|6");
  s.in(8, "");
  s.out(9, "c", "8");
  const Built g(s.body());
  EXPECT_EQ(g.into(1), "=");
  EXPECT_EQ(g.into(7), "=6");
  EXPECT_EQ(g.into(9), "=") << "an inVariable without a text is not connected";
  EXPECT_EQ(g.codes(), "P3001 P3003 P3003 P3003 P3003");
}

TEST(Graph, WiresLeadToInputs) {
  Sketch s;
  s.in(1, "a");
  test::BodyBuilder::feed(s.in(2, "b"), {1});
  test::BodyBuilder::feed(s.rail(3), {1});
  test::BodyBuilder::feed(s.out(4, "c", "1"), {2});
  const Built g(s.body());
  EXPECT_EQ(g.into(2), "=");
  EXPECT_EQ(g.into(4), "=1 =2");
  EXPECT_EQ(g.codes(), "P3003 P3003 P3013");
}

TEST(Graph, ARefusedConnectionWasReportedBefore) {
  Sketch s;
  s.in(1, "n");
  auto& out = s.out(2, "a", "1|77");
  out.inputs[0].connections[1].refused = true;
  const Built g(s.body());
  EXPECT_EQ(g.into(2), "=1");
  EXPECT_EQ(g.codes(), "");
}

TEST(Graph, OfTwoElementsWithOneIdTheFirstIsMeant) {
  Sketch s;
  s.in(1, "first");
  s.in(1, "second");
  s.out(2, "a", "1");
  const Built g(s.body());
  EXPECT_EQ(g.graph.element(g.graph.wires_into(2)[0].from.node).text, "first");
}

// ---- connectors ---------------------------------------------------------------------------------------------------

TEST(Graph, AContinuationReadsTheConnectorOfItsName) {
  Sketch s;
  s.continuation(1, "k");
  s.out(2, "a", "1");
  s.in(3, "n");
  s.connector(4, "K", "3");
  const Built g(s.body());
  EXPECT_EQ(g.into(1), "=4");
  EXPECT_EQ(g.into(2), "=1");
  EXPECT_EQ(g.into(4), "=3");
  EXPECT_EQ(g.codes(), "");
}

TEST(Graph, ConnectorsMustBeThereOnce) {
  Sketch s;
  s.in(1, "n");
  s.connector(2, "K", "1");
  s.connector(3, "k", "1");
  s.continuation(4, "K");
  s.continuation(5, "missing");
  const Built g(s.body());
  EXPECT_EQ(g.codes(), "P3004 P3005");
  EXPECT_EQ(g.into(4), "=2");
}

// ---- closed branches ----------------------------------------------------------------------------------------------

/// Contact 2, then a line through box 3 beside a line through contact 4; coil 5 where they meet, mark 9.
plcopen::Body closed(bool short_circuit) {
  Sketch s(plcopen::Language::kLd);
  s.rail(1);
  s.contact(2, "Ready", "1");
  s.block(3, "TON t", "IN=2", "Q");
  s.contact(4, "Bypass", "2");
  s.coil(5, "Go", "9");
  s.close(9, short_circuit, "2", {"3.Q", "4"});
  return s.body();
}

TEST(ClosedBranch, IsWhereItsLinesMeet) {
  const Built g(closed(false));
  EXPECT_EQ(g.into(5), "=3.Q,4");
  EXPECT_EQ(g.into(3), "IN=2");
}

TEST(ClosedBranch, WithShortCircuitGivesItsBoxesAnEnable) {
  const Built g(closed(true));
  EXPECT_EQ(g.into(5), "=3.Q,4");
  EXPECT_EQ(g.into(3), "IN=2 !EN=4");
  EXPECT_EQ(g.into(4), "=2") << "inputs after the box moved on, and lead to the same";
}

TEST(ClosedBranch, WhereEveryLineHoldsABoxNothingIsSkipped) {
  plcopen::Body body = closed(true);
  Sketch s;
  s.block(4, "TON u", "IN=2", "Q");
  body.elements[3] = s.body().elements[0];
  body.closed_branches[0].lines[1].connections[0].formal_parameter = "Q";
  const Built g(body);
  EXPECT_EQ(g.into(3), "IN=2");
  EXPECT_EQ(g.into(4), "IN=2");
}

TEST(ClosedBranch, LeavesBoxesInFrontOfItAlone) {
  plcopen::Body body = closed(true);
  Sketch s;
  s.block(2, "TON front", "IN=1", "Q");
  body.elements[1] = s.body().elements[0];
  const Built g(body);
  EXPECT_EQ(g.into(2), "IN=1");
  EXPECT_EQ(g.into(3), "IN=2.Q !EN=4");
}

TEST(ClosedBranch, AWireFromAMarkThatIsInItselfEnds) {
  plcopen::Body body = closed(false);
  body.closed_branches[0].lines[1].connections[0].ref_local_id = 9;
  EXPECT_EQ(Built(body).into(5), "=3.Q");
}

}  // namespace
}  // namespace plc
