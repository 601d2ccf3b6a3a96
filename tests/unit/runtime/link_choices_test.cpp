// Short IFs in loops that the interpreter computes both ways: which ones, and that nobody sees it. Random programs:
// tests/engines.
#include <gtest/gtest.h>

#include "tests/unit/runtime/counted_loop.h"

namespace plc::test {
namespace {

/// IF x[i] > 0 THEN .. ELSE .. END_IF
void if_positive(CountedLoop& l, const std::function<void(Word element)>& yes,
                 const std::function<void(Word element)>& no) {
  const Word element = l.load_from(l.x, l.i);
  const Word positive = l.main.frame("positive", l.b.boolean());
  l.main.op(Opcode::kGtI32, {positive, element, l.number(0)});
  const std::uint32_t other = l.main.jump(Opcode::kCondJump, {positive});
  yes(element);
  if (no) {
    const std::uint32_t end = l.main.jump(Opcode::kJump, {});
    l.main.land(other);
    no(element);
    l.main.land(end);
  } else {
    l.main.land(other);
  }
}

TEST(Choices, BothBranchesOfAnIf) {
  CountedLoop loop(0, 9, [](CountedLoop& l) {
    const Word up = l.main.variable("up", l.dint), down = l.main.variable("down", l.dint);
    const Word both = l.main.variable("both", l.dint);
    if_positive(
        l,
        [&](Word element) {
          l.main.op(Opcode::kAdd32, {up, up, element});
          l.main.op(Opcode::kAdd32, {both, both, l.number(1)});
        },
        [&](Word element) {
          l.main.op(Opcode::kAdd32, {down, down, element});
          l.main.op(Opcode::kSub32, {both, down, l.i});
        });
  });
  const auto report = loop.report();
  EXPECT_EQ(report.choices, 1u);
  EXPECT_EQ(report.loops, 0u);
}

TEST(Choices, WhatIsAssignedIsReadInTheSameBranch) {
  CountedLoop loop(0, 20, [](CountedLoop& l) {
    const Word a = l.main.variable("a", l.dint), c = l.main.variable("c", l.dint);
    if_positive(
        l,
        [&](Word element) {
          l.main.op(Opcode::kAdd32, {a, c, element});
          l.main.op(Opcode::kMul32, {c, a, l.number(3)});
        },
        nullptr);
  });
  EXPECT_EQ(loop.report().choices, 1u);
  EXPECT_NE(value_of(*loop.arranged, "Main0.c"), "0");
}

TEST(Choices, ABranchThatDoesMoreThanComputeIsJumpedTo) {
  CountedLoop loop(0, 20, [](CountedLoop& l) {
    if_positive(
        l, [&](Word element) { l.store_to(l.y, l.i, element); }, nullptr);
  });
  EXPECT_EQ(loop.report().choices, 0u);
  EXPECT_EQ(value_of(*loop.arranged, "Main0.y[2]"), "5");
}

TEST(Choices, TheConditionIsNotAssigned) {
  CountedLoop loop(0, 20, [](CountedLoop& l) {
    const Word flag = l.main.variable("flag", l.b.boolean());
    const std::uint32_t end = l.main.jump(Opcode::kJumpIf, {flag});
    l.main.op(Opcode::kGtI32, {flag, l.i, l.number(7)});
    l.main.land(end);
  });
  EXPECT_EQ(loop.report().choices, 0u);
  EXPECT_EQ(value_of(*loop.arranged, "Main0.flag"), "1");
}

TEST(Choices, TheBudgetEndsTheLoopAtItsPlace) {
  CountedLoop loop(0, 90, [](CountedLoop& l) {
    const Word up = l.main.variable("up", l.dint);
    if_positive(
        l,
        [&](Word element) {
          l.main.op(Opcode::kAdd32, {up, up, element});
        },
        nullptr);
  });
  EXPECT_EQ(loop.report(50).choices, 1u);
  EXPECT_EQ(loop.fault.kind, runtime::FaultKind::kLoopBudget);
}

TEST(Choices, EventsNameTheInstructionsTheyCameFrom) {
  // Behind the IF an index leaves its array.
  CountedLoop loop(95, 110, [](CountedLoop& l) {
    const Word up = l.main.variable("up", l.dint);
    if_positive(
        l,
        [&](Word element) {
          l.main.op(Opcode::kAdd32, {up, up, element});
        },
        nullptr);
    l.store_to(l.y, l.i, up);
  });
  EXPECT_EQ(loop.report().choices, 1u);
  EXPECT_GT(loop.arranged->program(0).event_total(), 0u);
  const auto events = loop.arranged->program(0).events(), expected = loop.plain->program(0).events();
  ASSERT_EQ(events.size(), expected.size());
  for (std::size_t n = 0; n < events.size(); ++n) {
    EXPECT_EQ(events[n].word, expected[n].word);
    EXPECT_EQ(events[n].count, expected[n].count);
  }
}

}  // namespace
}  // namespace plc::test
