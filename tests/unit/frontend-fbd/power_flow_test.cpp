// PowerFlows: AND and OR of flows, with what branches have in common taken out of them.
#include "frontend-fbd/power_flow.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "tests/support/module_builder.h"

namespace plc {
namespace {

using fbd::PowerFlows;
using ir::Op;
using ir::ValueId;
using test::ModuleBuilder;

/// The value under an assignment of the loads, in the order in which they were made.
bool test_value(const ir::Body& body, ValueId of, unsigned bits) {
  std::vector<bool> values;
  unsigned loads = 0;
  for (const ir::Inst& inst : body.insts) {
    switch (inst.op) {
      case Op::kLoad:
        values.push_back((bits >> loads++ & 1) != 0);
        break;
      case Op::kAnd:
        values.push_back(values[inst.a] && values[inst.b]);
        break;
      case Op::kOr:
        values.push_back(values[inst.a] || values[inst.b]);
        break;
      default:
        ADD_FAILURE() << "power is AND and OR of loads";
        values.push_back(false);
    }
  }
  return values[of.index];
}

struct PowerFlow : testing::Test {
  ModuleBuilder m;
  std::uint32_t main = m.pou("Main");
  ir::Builder b = m.body(main);
  PowerFlows flows;

  ValueId variable(const std::string& name) { return b.load(b.variable(m.variable(main, name, ir::kBoolType))); }
  std::size_t count(Op op) {
    std::size_t n = 0;
    for (const ir::Inst& inst : b.body().insts) n += inst.op == op;
    return n;
  }
  bool value(ValueId of, unsigned bits) { return test_value(b.body(), of, bits); }
};

TEST_F(PowerFlow, OfFlowsWithNothingInCommonIsOr) {
  const ValueId x = variable("x"), y = variable("y");
  const ValueId both = flows.parallel(b, x, y);
  EXPECT_EQ(count(Op::kOr), 1u);
  EXPECT_EQ(count(Op::kAnd), 0u);
  EXPECT_FALSE(value(both, 0));
  EXPECT_TRUE(value(both, 1) && value(both, 2));
}

TEST_F(PowerFlow, OfOneFlowWithItselfIsTheFlow) {
  const ValueId x = variable("x");
  EXPECT_EQ(flows.parallel(b, x, x).index, x.index);
  EXPECT_EQ(b.body().insts.size(), 1u);
}

TEST_F(PowerFlow, PastAContactIsTheFlowInFrontOfIt) {
  const ValueId x = variable("x"), y = variable("y");
  const ValueId in_series = flows.series(b, x, y);
  EXPECT_EQ(flows.parallel(b, in_series, x).index, x.index);
  EXPECT_EQ(flows.parallel(b, x, in_series).index, x.index);
  EXPECT_EQ(count(Op::kOr), 0u);
}

TEST_F(PowerFlow, OfBranchesFromOneFlowEvaluatesItOnce) {
  const ValueId x = variable("x"), y = variable("y"), z = variable("z"), w = variable("w");
  const ValueId upper = flows.series(b, flows.series(b, x, y), z);
  const ValueId lower = flows.series(b, x, w);
  const ValueId joined = flows.parallel(b, upper, lower);
  const ir::Inst& last = b.body().insts[joined.index];
  EXPECT_EQ(last.op, Op::kAnd) << "x AND (y AND z OR w)";
  EXPECT_EQ(last.a, x.index);
  EXPECT_EQ(b.body().insts[last.b].op, Op::kOr);
  for (unsigned bits = 0; bits < 16; ++bits) {
    const bool expected = (bits & 1) && (((bits & 2) && (bits & 4)) || (bits & 8));
    EXPECT_EQ(value(joined, bits), expected) << bits;
  }
}

TEST_F(PowerFlow, JoinedFlowsAreStepsThemselves) {
  const ValueId x = variable("x"), y = variable("y"), z = variable("z"), w = variable("w");
  const ValueId inner = flows.parallel(b, flows.series(b, x, y), flows.series(b, x, z));
  const ValueId outer = flows.parallel(b, inner, flows.series(b, x, w));
  EXPECT_EQ(b.body().insts[outer.index].a, x.index) << "the branch inside the branch begins at x, too";
  for (unsigned bits = 0; bits < 16; ++bits) EXPECT_EQ(value(outer, bits), (bits & 1) && (bits & 14)) << bits;
}

// Looked back over is a limited way only: what lies farther in front is not found, and not needed.
TEST_F(PowerFlow, OfLongWaysIsRightWithAndWithoutTheCommonFlow) {
  for (const unsigned length : {10u, 62u, 63u, 64u, 65u, 200u}) {
    const ValueId x = variable("x" + std::to_string(length)), y = variable("y" + std::to_string(length));
    const unsigned first = static_cast<unsigned>(count(Op::kLoad)) - 2;
    ValueId end = x;
    for (unsigned i = 0; i < length; ++i) end = flows.series(b, end, y);
    const ValueId past = flows.parallel(b, end, x);
    for (unsigned bits = 0; bits < 4; ++bits) EXPECT_EQ(value(past, bits << first), (bits & 1) != 0) << length;
    EXPECT_EQ(past.index == x.index, length < 64) << length;
  }
}

TEST_F(PowerFlow, OfRandomLaddersIsThatOfPlainLogic) {
  std::mt19937 random(7);
  for (int round = 0; round < 200; ++round) {
    ModuleBuilder own;
    const std::uint32_t pou = own.pou("Main");
    ir::Builder builder = own.body(pou);
    PowerFlows fresh;
    struct Flow {
      ValueId value;
      unsigned truth;  ///< bit i: the value under assignment i of four variables
    };
    constexpr unsigned kTruth[] = {0xaaaa, 0xcccc, 0xf0f0, 0xff00};
    std::vector<Flow> states, all;
    for (unsigned v = 0; v < 4; ++v) {
      const auto index = own.variable(pou, std::string(1, static_cast<char>('a' + v)), ir::kBoolType);
      states.push_back({builder.load(builder.variable(index)), kTruth[v]});
    }
    all = {states[0], states[1]};
    for (int step = 0; step < 12; ++step) {
      const Flow one = all[random() % all.size()], two = all[random() % all.size()];
      const Flow& state = states[random() % 4];
      if (random() % 2 == 0) {
        all.push_back({fresh.series(builder, one.value, state.value), one.truth & state.truth});
      } else {
        all.push_back({fresh.parallel(builder, one.value, two.value), one.truth | two.truth});
      }
    }
    for (unsigned bits = 0; bits < 16; ++bits) {
      ASSERT_EQ(test_value(builder.body(), all.back().value, bits), (all.back().truth >> bits & 1) != 0)
          << round << " " << bits;
    }
  }
}

}  // namespace
}  // namespace plc
