// The execution order of docs/guides/execution-order.md, rule by rule, on graphs built by hand.
#include "frontend-fbd/order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/support/body_builder.h"

namespace plc {
namespace {

using core::ElementKind;
using core::Order;
using test::BodyBuilder;

struct Ordered {
  std::vector<std::int64_t> ids;
  std::vector<std::pair<std::int64_t, std::int64_t>> feedback;  // from, to
  std::size_t errors = 0;
};

Ordered ordered(const plcopen::Body& body, Order rule = Order::kDrawing) {
  core::Diagnostics diagnostics;
  fbd::Graph graph = fbd::build_graph(body, "P", diagnostics);
  const fbd::Sequence sequence = fbd::order(graph, rule, "P", diagnostics);
  Ordered result;
  for (const fbd::Step& step : sequence.steps) {
    result.ids.push_back(graph.element(step.node).at.local_id);
    const fbd::Node& node = graph.nodes[step.node];
    for (std::uint32_t i = node.first_input; i < node.first_input + node.input_count; ++i) {
      for (std::uint32_t w = 0; w < graph.inputs[i].wire_count; ++w) {
        const fbd::Wire& wire = graph.wires[graph.inputs[i].first_wire + w];
        if (wire.feedback) result.feedback.emplace_back(graph.element(wire.from.node).at.local_id, result.ids.back());
      }
    }
  }
  result.errors = diagnostics.error_count();
  return result;
}

using Ids = std::vector<std::int64_t>;

TEST(Order, ExecutionOrderIdsComeFirstAndEqualIdsKeepDocumentOrder) {
  BodyBuilder b(plcopen::Language::kFbd);
  const auto out = [&](std::int64_t id, std::uint32_t order, std::int32_t y) {
    b.add(ElementKind::kInVariable, id, "x", 0, y);
    auto& e = b.add(ElementKind::kOutVariable, id + 100, "y", 100, y);
    e.execution_order = order;
    BodyBuilder::feed(e, {id});
  };
  out(1, 3, 10);
  out(2, 3, 0);
  out(3, 1, 90);
  out(4, 0, 0);
  EXPECT_EQ(ordered(b.body()).ids, (Ids{3, 103, 1, 101, 2, 102, 4, 104}));
  EXPECT_EQ(ordered(b.body(), Order::kDocument).ids, (Ids{3, 103, 1, 101, 2, 102, 4, 104}));
}

TEST(Order, NetworksGoTopToBottomThenLeftToRightWhateverTheDocumentOrder) {
  BodyBuilder b(plcopen::Language::kFbd);
  const auto network = [&](std::int64_t id, std::int32_t x, std::int32_t y) {
    b.add(ElementKind::kInVariable, id, "a", x, y);
    BodyBuilder::feed(b.add(ElementKind::kOutVariable, id + 1, "b", x + 50, y), {id});
  };
  network(10, 0, 200);
  network(20, 300, 50);
  network(30, 0, 50);
  EXPECT_EQ(ordered(b.body()).ids, (Ids{30, 31, 20, 21, 10, 11}));
  EXPECT_EQ(ordered(b.body(), Order::kDocument).ids, (Ids{10, 11, 20, 21, 30, 31}));
}

TEST(Order, WithoutPositionsTheDocumentDecides) {
  BodyBuilder b(plcopen::Language::kFbd);
  for (std::int64_t id : {30, 10, 20}) {
    b.add(ElementKind::kInVariable, id, "a", 0, 0);
    BodyBuilder::feed(b.add(ElementKind::kOutVariable, id + 1, "b", 0, 0), {id});
  }
  EXPECT_EQ(ordered(b.body()).ids, (Ids{30, 31, 10, 11, 20, 21}));
}

TEST(Order, PowerRailsDoNotConnectNetworks) {
  BodyBuilder b(plcopen::Language::kLd);
  b.add(ElementKind::kLeftRail, 1, "", 0, 0);
  auto& low_contact = b.add(ElementKind::kContact, 2, "A", 10, 100);
  BodyBuilder::feed(low_contact, {1});
  BodyBuilder::feed(b.add(ElementKind::kCoil, 3, "B", 90, 100), {2});
  auto& high_contact = b.add(ElementKind::kContact, 4, "C", 10, 10);
  BodyBuilder::feed(high_contact, {1});
  BodyBuilder::feed(b.add(ElementKind::kCoil, 5, "D", 90, 10), {4});
  BodyBuilder::feed(b.add(ElementKind::kRightRail, 6, "", 200, 0), {3, 5});
  EXPECT_EQ(ordered(b.body()).ids, (Ids{1, 4, 5, 2, 3, 6}));
}

TEST(Order, DataFlowGoesBeforePositionInsideANetwork) {
  BodyBuilder b(plcopen::Language::kFbd);
  auto& block = b.add(ElementKind::kBlock, 1, "NOT", 100, 0);  // top-most, but fed from below
  BodyBuilder::pin(block, "IN", {2});
  BodyBuilder::out(block, "OUT");
  b.add(ElementKind::kInVariable, 2, "a", 0, 300);
  BodyBuilder::feed(b.add(ElementKind::kOutVariable, 3, "b", 200, 0), {1});
  EXPECT_EQ(ordered(b.body()).ids, (Ids{2, 1, 3}));
}

TEST(Order, AnInOutVariableOnALoopFeedsItsFirstReaderWithThePreviousScan) {
  BodyBuilder b(plcopen::Language::kFbd);
  auto& add = b.add(ElementKind::kBlock, 4, "ADD", 100, 10);
  BodyBuilder::pin(add, "IN1", {6});
  BodyBuilder::pin(add, "IN2", {3});
  BodyBuilder::out(add, "OUT");
  b.add(ElementKind::kInVariable, 6, "1", 0, 10);
  BodyBuilder::feed(b.add(ElementKind::kInOutVariable, 3, "Cnt", 200, 10), {4});
  BodyBuilder::feed(b.add(ElementKind::kOutVariable, 2, "Out", 300, 10), {3});
  const Ordered o = ordered(b.body());
  EXPECT_EQ(o.ids, (Ids{6, 4, 3, 2}));
  EXPECT_EQ(o.feedback, (std::vector<std::pair<std::int64_t, std::int64_t>>{{3, 4}}));
}

TEST(Order, ALoopOfBlocksStartsAtItsTopMostElement) {
  BodyBuilder b(plcopen::Language::kFbd);
  auto& low = b.add(ElementKind::kBlock, 1, "TON", 100, 100);
  BodyBuilder::pin(low, "IN", {2}, "OUT");
  BodyBuilder::out(low, "Q");
  auto& high = b.add(ElementKind::kBlock, 2, "NOT", 100, 10);
  BodyBuilder::pin(high, "IN", {1}, "Q");
  BodyBuilder::out(high, "OUT");
  const Ordered o = ordered(b.body());
  EXPECT_EQ(o.ids, (Ids{2, 1}));
  EXPECT_EQ(o.feedback, (std::vector<std::pair<std::int64_t, std::int64_t>>{{1, 2}}));
  EXPECT_EQ(o.errors, 0u);
}

TEST(Order, PowerFlowThatDependsOnItselfIsAnError) {
  BodyBuilder b(plcopen::Language::kLd);
  BodyBuilder::feed(b.add(ElementKind::kContact, 1, "A", 0, 0), {2});
  BodyBuilder::feed(b.add(ElementKind::kContact, 2, "B", 50, 0), {1});
  EXPECT_EQ(ordered(b.body()).errors, 1u);
  EXPECT_EQ(ordered(b.body(), Order::kDocument).errors, 1u);
}

TEST(Order, ManyBlocksThatReadAfterOneLongChainTakeTimeInProportion) {
  BodyBuilder b(plcopen::Language::kLd);
  constexpr std::int64_t kCount = 20'000;
  const std::int64_t last = 2 * kCount - 1;
  for (std::int64_t id = 0; id < kCount; ++id) {  // each reads the end of the chain, each feeds one contact of it
    auto& block = b.add(ElementKind::kBlock, id, "OR", 0, static_cast<std::int32_t>(id));
    BodyBuilder::pin(block, "IN", {last});
    BodyBuilder::out(block, "OUT");
  }
  for (std::int64_t id = kCount; id <= last; ++id) {
    auto& contact = b.add(ElementKind::kContact, id, "A", 50, static_cast<std::int32_t>(id));
    BodyBuilder::feed(contact, id == kCount ? std::vector{id - kCount} : std::vector{id - kCount, id - 1});
  }
  for (Order rule : {Order::kDrawing, Order::kDocument}) {
    const Ordered o = ordered(b.body(), rule);
    EXPECT_EQ(o.errors, 0u);
    EXPECT_EQ(o.ids.size(), static_cast<std::size_t>(2 * kCount));
  }
}

TEST(Order, ALargeNetThatDependsOnItselfIsOneError) {
  BodyBuilder b(plcopen::Language::kLd);
  constexpr std::int64_t kContacts = 20'000;
  for (std::int64_t id = 0; id < kContacts; ++id) {
    BodyBuilder::feed(b.add(ElementKind::kContact, id, "A", static_cast<std::int32_t>(id), 0),
                      {(id + kContacts - 1) % kContacts, (id + 1) % kContacts});
  }
  EXPECT_EQ(ordered(b.body()).errors, 1u);
}

TEST(Order, DanglingWiresAndSelfConnectionsAreHandled) {
  BodyBuilder b(plcopen::Language::kFbd);
  auto& block = b.add(ElementKind::kBlock, 1, "ADD", 0, 0);
  BodyBuilder::pin(block, "IN1", {1}, "OUT");
  BodyBuilder::pin(block, "IN2", {77});
  BodyBuilder::out(block, "OUT");
  const Ordered o = ordered(b.body());
  EXPECT_EQ(o.ids, (Ids{1}));
  EXPECT_EQ(o.feedback.size(), 1u);
}

TEST(Order, ElementsWithoutAPlaceAmongOthersAreNamedOnce) {
  BodyBuilder b(plcopen::Language::kFbd);
  b.add(ElementKind::kInVariable, 1, "x", 40, 50);
  BodyBuilder::feed(b.add(ElementKind::kOutVariable, 2, "y", 90, 50), {1});
  b.add(ElementKind::kInVariable, 3, "y", 0, 0).has_position = false;
  auto& out = b.add(ElementKind::kOutVariable, 4, "z", 0, 0);
  out.has_position = false;
  BodyBuilder::feed(out, {3});
  for (const Order rule : {Order::kDrawing, Order::kDocument}) {
    core::Diagnostics diagnostics;
    fbd::Graph graph = fbd::build_graph(b.body(), "P", diagnostics);
    const fbd::Sequence sequence = fbd::order(graph, rule, "P", diagnostics);
    EXPECT_EQ(sequence.steps.size(), 4u);
    ASSERT_EQ(diagnostics.all().size(), rule == Order::kDrawing ? 1u : 0u);
    if (rule == Order::kDocument) continue;
    EXPECT_EQ(core::info(diagnostics.all()[0].code).name, "P3018");
    EXPECT_NE(diagnostics.all()[0].message.find("inVariable y and 1 more have no position"), std::string::npos);
  }
}

// ---- jumps and labels ---------------------------------------------------------------------------------------------

TEST(Order, ALabelHeadsTheNetworkBesideIt) {
  BodyBuilder b(plcopen::Language::kFbd);
  b.add(ElementKind::kInVariable, 1, "x", 40, 0);
  BodyBuilder::feed(b.add(ElementKind::kOutVariable, 2, "y", 90, 0), {1});
  auto& block = b.add(ElementKind::kBlock, 3, "OR", 40, 100);
  block.height = 200;
  BodyBuilder::out(block, "OUT");
  BodyBuilder::feed(b.add(ElementKind::kOutVariable, 4, "z", 90, 140), {3});
  b.add(ElementKind::kLabel, 5, "lower_than_the_top", 20, 110);
  b.add(ElementKind::kLabel, 6, "nearer_to_the_next", 20, 190);
  b.add(ElementKind::kInVariable, 7, "x", 40, 200);
  BodyBuilder::feed(b.add(ElementKind::kOutVariable, 8, "y", 90, 200), {7});
  b.add(ElementKind::kLabel, 9, "to_the_right", 200, 290);
  EXPECT_EQ(ordered(b.body()).ids, (Ids{1, 2, 5, 3, 4, 6, 7, 8, 9}));
}

TEST(Order, ALabelComesFirstAmongWhatFollowsItsTitle) {
  BodyBuilder b(plcopen::Language::kLd);
  for (std::int64_t id : {1, 3}) {
    b.add(ElementKind::kInVariable, id, "x", 0, 0).network = id == 1 ? 1 : 2;
    auto& out = b.add(ElementKind::kOutVariable, id + 1, "y", 0, 0);
    out.network = id == 1 ? 1 : 2;
    BodyBuilder::feed(out, {id});
  }
  b.add(ElementKind::kLabel, 5, "L", 0, 0).network = 2;
  EXPECT_EQ(ordered(b.body()).ids, (Ids{1, 2, 5, 3, 4}));
}

TEST(Order, JumpsWithoutAnIdAmongElementsThatHaveOneAreNamed) {
  BodyBuilder b(plcopen::Language::kFbd);
  b.add(ElementKind::kJump, 1, "L", 0, 0);
  b.add(ElementKind::kInVariable, 2, "x", 0, 50);
  auto& out = b.add(ElementKind::kOutVariable, 3, "y", 50, 50);
  out.execution_order = 1;
  BodyBuilder::feed(out, {2});
  b.add(ElementKind::kLabel, 4, "L", 0, 100);
  core::Diagnostics diagnostics;
  fbd::Graph graph = fbd::build_graph(b.body(), "P", diagnostics);
  const fbd::Sequence sequence = fbd::order(graph, Order::kDrawing, "P", diagnostics);
  EXPECT_EQ(sequence.steps.size(), 4u);
  ASSERT_EQ(diagnostics.all().size(), 1u);
  EXPECT_EQ(core::info(diagnostics.all()[0].code).name, "P3018");
  EXPECT_NE(diagnostics.all()[0].message.find("jump to \"L\" has no executionOrderId"), std::string::npos);
}

TEST(Order, OneZeroAmongIdsIsNamed) {
  for (const int zeros : {1, 2}) {
    BodyBuilder b(plcopen::Language::kFbd);
    b.add(ElementKind::kInVariable, 1, "x", 0, 0).order_zero = zeros == 2;
    for (std::uint32_t order : {0u, 1u}) {
      auto& out = b.add(ElementKind::kOutVariable, order + 2, "y", 50, 50);
      out.execution_order = order;
      out.order_zero = order == 0;
      BodyBuilder::feed(out, {1});
    }
    core::Diagnostics diagnostics;
    fbd::Graph graph = fbd::build_graph(b.body(), "P", diagnostics);
    const fbd::Sequence sequence = fbd::order(graph, Order::kDrawing, "P", diagnostics);
    EXPECT_EQ(sequence.steps.size(), 3u);
    EXPECT_EQ(diagnostics.all().size(), zeros == 1 ? 1u : 0u);
  }
}

// ---- reading for a reader, writing with a block -------------------------------------------------------------------

plcopen::Element& add_block(BodyBuilder& b, std::int64_t id, std::int32_t x, std::int32_t y,
                            std::vector<std::int64_t> in = {}, const std::string& from_pin = "OUT") {
  auto& block = b.add(ElementKind::kBlock, id, "OR", x, y);
  if (!in.empty()) BodyBuilder::pin(block, "IN", std::move(in), from_pin);
  BodyBuilder::out(block, "OUT");
  return block;
}

TEST(Order, AnOutVariableIsWrittenWithItsBlockHoweverLowItIsDrawn) {
  BodyBuilder b(plcopen::Language::kFbd);
  add_block(b, 1, 0, 10);
  BodyBuilder::feed(b.add(ElementKind::kOutVariable, 2, "V", 50, 300), {1});
  BodyBuilder::feed(b.add(ElementKind::kOutVariable, 3, "W", 50, 200), {1});
  b.add(ElementKind::kInVariable, 4, "V", 100, 0);
  add_block(b, 5, 150, 20, {4, 1});
  for (Order rule : {Order::kDrawing, Order::kDocument}) EXPECT_EQ(ordered(b.body(), rule).ids, (Ids{1, 3, 2, 4, 5}));
}

TEST(Order, AnOutVariableOfJoinedBlocksIsWrittenAfterTheLastOfThem) {
  BodyBuilder b(plcopen::Language::kFbd);
  add_block(b, 1, 0, 10);
  add_block(b, 2, 0, 50);
  BodyBuilder::feed(b.add(ElementKind::kOutVariable, 3, "V", 50, 0), {1, 2});
  b.add(ElementKind::kInVariable, 4, "V", 0, 0);
  add_block(b, 5, 100, 90, {4, 1});
  EXPECT_EQ(ordered(b.body()).ids, (Ids{1, 2, 3, 4, 5}));
}

TEST(Order, ConnectorsBetweenABlockAndItsOutVariableAreWires) {
  BodyBuilder b(plcopen::Language::kFbd);
  add_block(b, 1, 0, 10);
  BodyBuilder::feed(b.add(ElementKind::kConnector, 2, "K", 50, 10), {1});
  b.add(ElementKind::kContinuation, 3, "K", 0, 400);
  BodyBuilder::feed(b.add(ElementKind::kOutVariable, 4, "V", 50, 400), {3});
  b.add(ElementKind::kInVariable, 5, "V", 0, 100);
  add_block(b, 6, 100, 100, {5, 1});
  for (Order rule : {Order::kDrawing, Order::kDocument}) {
    EXPECT_EQ(ordered(b.body(), rule).ids, (Ids{1, 2, 3, 4, 5, 6}));
  }
}

TEST(Order, AnOutVariableAfterAContactHasAPlaceOfItsOwn) {
  BodyBuilder b(plcopen::Language::kLd);
  add_block(b, 1, 0, 10);
  BodyBuilder::feed(b.add(ElementKind::kContact, 2, "A", 50, 10), {1});
  BodyBuilder::feed(b.add(ElementKind::kOutVariable, 3, "V", 90, 300), {2});
  BodyBuilder::feed(b.add(ElementKind::kCoil, 4, "C", 90, 50), {1});
  EXPECT_EQ(ordered(b.body()).ids, (Ids{1, 4, 2, 3}));
}

TEST(Order, AContactIsReadForTheFirstThatNeedsItWithAllInFrontOfIt) {
  BodyBuilder b(plcopen::Language::kLd);
  b.add(ElementKind::kLeftRail, 1, "", 0, 0);
  BodyBuilder::feed(b.add(ElementKind::kContact, 2, "A", 10, 10), {1});
  BodyBuilder::feed(b.add(ElementKind::kContact, 3, "B", 20, 10), {2});
  BodyBuilder::feed(b.add(ElementKind::kContact, 4, "C", 30, 10), {3});
  BodyBuilder::feed(b.add(ElementKind::kCoil, 5, "Low", 90, 90), {4});
  BodyBuilder::feed(b.add(ElementKind::kCoil, 6, "High", 90, 50), {3});  // takes A and B along, not C
  EXPECT_EQ(ordered(b.body()).ids, (Ids{1, 2, 3, 6, 4, 5}));
  EXPECT_EQ(ordered(b.body(), Order::kDocument).ids, (Ids{1, 2, 3, 4, 5, 6}));
}

TEST(Order, AnIdOfItsOwnGivesAVariableItsPlace) {
  BodyBuilder b(plcopen::Language::kFbd);
  add_block(b, 1, 0, 10).execution_order = 2;
  auto& out = b.add(ElementKind::kOutVariable, 2, "V", 50, 10);
  BodyBuilder::feed(out, {1});
  out.execution_order = 5;
  b.add(ElementKind::kInVariable, 3, "V", 0, 50).execution_order = 1;
  add_block(b, 4, 50, 50, {3}).execution_order = 3;
  EXPECT_EQ(ordered(b.body()).ids, (Ids{3, 1, 4, 2}));
}

TEST(Order, ContactsOnALoopAreReadInThisScan) {
  // OR 1 <- contact 2 <- OR 1, and the coil reads after the contact; the file has the coil first.
  BodyBuilder b(plcopen::Language::kLd);
  BodyBuilder::feed(b.add(ElementKind::kCoil, 3, "C", 90, 90), {2});
  BodyBuilder::feed(b.add(ElementKind::kContact, 2, "A", 10, 0), {1});
  add_block(b, 1, 50, 10, {2});
  for (Order rule : {Order::kDrawing, Order::kDocument}) {
    const Ordered o = ordered(b.body(), rule);
    EXPECT_EQ(o.ids, (Ids{2, 1, 3}));
    EXPECT_EQ(o.feedback, (std::vector<std::pair<std::int64_t, std::int64_t>>{{1, 2}}));
  }
}

/// Contacts, variables and blocks at random: what only reads comes right before its first reader, what blocks
/// write right after the last of them, whatever is drawn.
TEST(Order, RandomRungsReadLateAndWriteAtOnce) {
  std::mt19937 random(31);
  for (int round = 0; round < 500; ++round) {
    BodyBuilder b(plcopen::Language::kLd);
    const int count = 2 + static_cast<int>(random() % 40);
    const auto any = [&](int below) { return static_cast<std::int64_t>(random() % static_cast<unsigned>(below)); };
    for (int id = 0; id < count; ++id) {
      const auto x = static_cast<std::int32_t>(random() % 5), y = static_cast<std::int32_t>(random() % 5);
      constexpr ElementKind kKinds[] = {ElementKind::kContact, ElementKind::kInVariable, ElementKind::kBlock,
                                        ElementKind::kCoil, ElementKind::kOutVariable};
      const ElementKind kind = kKinds[random() % 5];
      auto& e = b.add(kind, id, "A", x, y);
      if (kind == ElementKind::kInVariable) continue;
      if (kind == ElementKind::kBlock) {
        BodyBuilder::pin(e, "IN1", {any(count)}, "OUT");  // forward, too: loops
        BodyBuilder::pin(e, "IN2", {any(count)}, "OUT");
        BodyBuilder::out(e, "OUT");
      } else if (id > 0) {
        BodyBuilder::feed(e, random() % 3 == 0 ? std::vector{any(id), any(id)} : std::vector{any(id)});
      }
    }
    for (Order rule : {Order::kDrawing, Order::kDocument}) {
      core::Diagnostics diagnostics;
      fbd::Graph graph = fbd::build_graph(b.body(), "P", diagnostics);
      const fbd::Sequence sequence = fbd::order(graph, rule, "P", diagnostics);
      ASSERT_EQ(sequence.steps.size(), static_cast<std::size_t>(count));
      const std::size_t none = sequence.steps.size();
      std::vector<std::size_t> at(sequence.steps.size(), none);
      for (std::size_t i = 0; i < sequence.steps.size(); ++i) at[sequence.steps[i].node] = i;
      std::vector<std::size_t> first_reader(sequence.steps.size(), none);
      for (fbd::NodeId n = 0; n < graph.nodes.size(); ++n) {
        for (const fbd::Wire& wire : graph.wires_into(n)) {
          ASSERT_EQ(wire.feedback, at[wire.from.node] >= at[n]);
          // Only what acts can be late; what is read for somebody is never a scan old.
          EXPECT_FALSE(wire.feedback && fbd::only_passes_on(graph, wire.from.node));
          first_reader[wire.from.node] = std::min(first_reader[wire.from.node], at[n]);
        }
      }
      for (std::size_t i = 0; i < sequence.steps.size(); ++i) {
        const fbd::NodeId n = sequence.steps[i].node;
        if (fbd::only_passes_on(graph, n)) {
          if (first_reader[n] == none) continue;
          for (std::size_t k = i + 1; k < first_reader[n]; ++k) {
            EXPECT_TRUE(fbd::only_passes_on(graph, sequence.steps[k].node)) << "something acts between read and reader";
          }
        } else if (graph.element(n).kind == ElementKind::kOutVariable && !graph.wires_into(n).empty()) {
          std::size_t last = 0;
          bool of_blocks = true;
          for (const fbd::Wire& wire : graph.wires_into(n)) {
            of_blocks = of_blocks && graph.element(wire.from.node).kind == ElementKind::kBlock && !wire.feedback;
            last = std::max(last, at[wire.from.node]);
          }
          for (std::size_t k = last + 1; of_blocks && k < i; ++k) {
            EXPECT_EQ(graph.element(sequence.steps[k].node).kind, ElementKind::kOutVariable);
          }
        }
      }
    }
  }
}

/// Every element is there once, and no wire that is not feedback leads backwards, whatever is drawn.
TEST(Order, RandomDrawingsKeepTheInvariants) {
  std::mt19937 random(20);
  for (int round = 0; round < 300; ++round) {
    BodyBuilder b(plcopen::Language::kFbd);
    const int count = 1 + static_cast<int>(random() % 40);
    for (int id = 0; id < count; ++id) {
      auto& e = b.add(ElementKind::kBlock, id, "ADD", static_cast<std::int32_t>(random() % 5),
                      static_cast<std::int32_t>(random() % 5));
      if (random() % 4 == 0) e.execution_order = static_cast<std::uint32_t>(random() % 5);
      for (unsigned pin = 0; pin < 2; ++pin) {
        if (random() % 3 != 0) {
          BodyBuilder::pin(e, pin == 0 ? "IN1" : "IN2",
                           {static_cast<std::int64_t>(random() % static_cast<unsigned>(count))}, "OUT");
        }
      }
      BodyBuilder::out(e, "OUT");
    }
    for (Order rule : {Order::kDrawing, Order::kDocument}) {
      core::Diagnostics diagnostics;
      fbd::Graph graph = fbd::build_graph(b.body(), "P", diagnostics);
      const fbd::Sequence sequence = fbd::order(graph, rule, "P", diagnostics);
      ASSERT_EQ(sequence.steps.size(), static_cast<std::size_t>(count));
      std::vector<int> position(static_cast<std::size_t>(count), -1);
      for (std::size_t i = 0; i < sequence.steps.size(); ++i) {
        ASSERT_EQ(position[sequence.steps[i].node], -1) << "placed twice";
        position[sequence.steps[i].node] = static_cast<int>(i);
      }
      for (fbd::NodeId n = 0; n < graph.nodes.size(); ++n) {
        const fbd::Node& node = graph.nodes[n];
        for (std::uint32_t i = node.first_input; i < node.first_input + node.input_count; ++i) {
          for (std::uint32_t w = 0; w < graph.inputs[i].wire_count; ++w) {
            const fbd::Wire& wire = graph.wires[graph.inputs[i].first_wire + w];
            EXPECT_EQ(wire.feedback, position[wire.from.node] >= position[n]);
          }
        }
      }
    }
  }
}

TEST(Order, AHundredThousandLoopsTakeTimeInProportion) {
  BodyBuilder b(plcopen::Language::kFbd);
  constexpr int kLoops = 50'000;
  for (int i = 0; i < kLoops; ++i) {
    auto& first = b.add(ElementKind::kBlock, 2 * i, "OR", 0, 0);
    BodyBuilder::pin(first, "IN1", {2 * i + 1}, "OUT");
    if (i > 0) BodyBuilder::pin(first, "IN2", {2 * i - 1}, "OUT");
    BodyBuilder::out(first, "OUT");
    auto& second = b.add(ElementKind::kBlock, 2 * i + 1, "NOT", 50, 0);
    BodyBuilder::pin(second, "IN", {2 * i}, "OUT");
    BodyBuilder::out(second, "OUT");
  }
  const Ordered o = ordered(b.body());
  EXPECT_EQ(o.ids.size(), 2u * kLoops);
  EXPECT_EQ(o.feedback.size(), static_cast<std::size_t>(kLoops));
}

}  // namespace
}  // namespace plc
