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
