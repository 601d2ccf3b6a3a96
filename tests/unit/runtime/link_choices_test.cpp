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

/// As a checksum does: IF (sum AND 1) <> 0 THEN sum := sum * 3 XOR 21 ELSE sum := sum * 3; every variable is read by
/// the next round.
void checksum(CountedLoop& l, Word seed) {
  const Word sum = l.main.variable("sum", l.dint), count = l.main.variable("count", l.dint);
  const Word bit = l.main.frame("bit", l.dint), odd = l.main.frame("odd", l.b.boolean());
  const Word tripled = l.temporary();
  l.main.op(Opcode::kAnd32, {bit, sum, l.number(1)});
  l.main.op(Opcode::kNe32, {odd, bit, l.number(0)});
  const std::uint32_t other = l.main.jump(Opcode::kCondJump, {odd});
  l.main.op(Opcode::kMul32, {tripled, sum, l.number(3)});
  l.main.op(Opcode::kXor32, {sum, tripled, seed});
  const std::uint32_t end = l.main.jump(Opcode::kJump, {});
  l.main.land(other);
  l.main.op(Opcode::kMul32, {sum, sum, l.number(3)});
  l.main.op(Opcode::kAdd32, {count, count, sum});
  l.main.land(end);
}

/// A shift register with feedback as the compiler makes it of ST: one temporary for the masked and the shifted word.
TEST(Choices, AStepOfAShiftRegisterIsOneInstruction) {
  for (const bool right : {false, true}) {
    for (const std::int32_t taps : {0x1234567, -5}) {
      CountedLoop loop(0, 20, [&](CountedLoop& l) {
        const Word first = l.b.constant<std::uint32_t>(TypeId::kDword, right ? 1 : 0x80000000u);
        const Word mixed = l.b.constant<std::uint32_t>(TypeId::kDword, static_cast<std::uint32_t>(taps));
        const Word zero = l.b.constant<std::uint32_t>(TypeId::kDword, 0);
        const Word word = l.main.variable("word", l.b.type(TypeId::kDword)), temporary = l.temporary(TypeId::kDword);
        const char* const shift = right ? "SHR:DWORD,DINT" : "SHL:DWORD,DINT";
        l.main.op(Opcode::kAnd32, {temporary, word, first});
        l.main.op(Opcode::kNe32, {l.more, temporary, zero});
        const std::uint32_t other = l.main.jump(Opcode::kCondJump, {l.more});
        l.main.call_std(shift, temporary, {word, l.number(1)});
        l.main.op(Opcode::kXor32, {word, temporary, mixed});
        const std::uint32_t end = l.main.jump(Opcode::kJump, {});
        l.main.land(other);
        l.main.call_std(shift, word, {word, l.number(1)});
        l.main.land(end);
        // Something to shift.
        l.main.op(Opcode::kAdd32, {word, word, l.b.constant<std::uint32_t>(TypeId::kDword, right ? 3 : 0x60000000u)});
      });
      EXPECT_EQ(loop.report().choices, 1u);
      EXPECT_NE(value_of(*loop.arranged, "Main0.word"), "0");
    }
  }
}

TEST(Choices, SeveralRoundsStandBehindEachOther) {
  for (const std::int32_t step : {1, 3, -1, -2}) {
    for (std::int32_t last = -1; last <= 40; ++last) {
      CountedLoop loop(
          step > 0 ? 0 : last, step > 0 ? last : 0, [](CountedLoop& l) { checksum(l, l.number(20)); }, step);
      const auto report = loop.report();
      EXPECT_EQ(report.choices, 1u);
      EXPECT_EQ(report.rounds, 1u) << step << ", " << last;
    }
  }
}

TEST(Choices, RoundsMayLookAtTheControlVariable) {
  for (const std::int32_t last : {5, 6, 7, 8, 15, 16, 30}) {
    CountedLoop loop(0, last, [](CountedLoop& l) { checksum(l, l.i); });
    EXPECT_EQ(loop.report().rounds, 1u) << last;
  }
}

TEST(Choices, RoundsMayCompareTheControlVariable) {
  for (const std::int32_t last : {6, 7, 8, 20}) {
    CountedLoop loop(0, last, [](CountedLoop& l) {
      const Word sum = l.main.variable("sum", l.dint), late = l.main.frame("late", l.b.boolean());
      l.main.op(Opcode::kGtI32, {late, l.i, l.number(3)});
      const std::uint32_t end = l.main.jump(Opcode::kCondJump, {late});
      l.main.op(Opcode::kAdd32, {sum, sum, l.number(1)});
      l.main.land(end);
    });
    EXPECT_EQ(loop.report().rounds, 1u) << last;
    EXPECT_EQ(value_of(*loop.arranged, "Main0.sum"), std::to_string(3 * (last - 3)));
  }
}

TEST(Choices, RoundsMayUseTheTemporaryOfTheLoop) {
  for (const std::int32_t last : {6, 7, 8, 20}) {
    CountedLoop loop(0, last, [](CountedLoop& l) {
      const Word sum = l.main.variable("sum", l.dint);
      l.main.op(Opcode::kNe32, {l.more, sum, l.number(5)});
      const std::uint32_t end = l.main.jump(Opcode::kCondJump, {l.more});
      l.main.op(Opcode::kAdd32, {sum, sum, l.number(1)});
      l.main.land(end);
    });
    EXPECT_EQ(loop.report().rounds, 1u) << last;
    EXPECT_EQ(value_of(*loop.arranged, "Main0.sum"), "5");
  }
  CountedLoop reads(0, 20, [](CountedLoop& l) {
    const Word sum = l.main.variable("sum", l.dint);
    const std::uint32_t end = l.main.jump(Opcode::kCondJump, {l.more});  // of the round before
    l.main.op(Opcode::kAdd32, {sum, sum, l.number(1)});
    l.main.land(end);
  });
  EXPECT_EQ(reads.report().rounds, 0u);
}

TEST(Choices, RoundsEndWithTheBudget) {
  for (std::uint32_t budget = 1; budget <= 40; ++budget) {
    CountedLoop loop(0, 30, [](CountedLoop& l) { checksum(l, l.i); });
    EXPECT_EQ(loop.report(budget).rounds, 1u);
    EXPECT_EQ(loop.fault.kind, budget < 30 ? runtime::FaultKind::kLoopBudget : runtime::FaultKind::kNone) << budget;
  }
}

TEST(Choices, NoSeveralRoundsOfWhatCountsItself) {
  CountedLoop counts(0, 60, [](CountedLoop& l) {
    checksum(l, l.number(20));
    l.main.op(Opcode::kAdd32, {l.i, l.i, l.number(1)});
  });
  EXPECT_EQ(counts.report().choices, 1u);
  EXPECT_EQ(counts.report().rounds, 0u);
  CountedLoop elements(0, 60, [](CountedLoop& l) {
    checksum(l, l.number(20));
    l.store_to(l.y, l.i, l.i);
  });
  EXPECT_EQ(elements.report().choices, 1u);
  EXPECT_EQ(elements.report().rounds, 0u);
}

TEST(Choices, AConditionalValueReadsWhatAnotherAssignmentChanges) {
  // b := b + a must see a as it was before a := a + 5, whichever is chosen first.
  for (const bool turned : {false, true}) {
    CountedLoop loop(0, 20, [turned](CountedLoop& l) {
      const Word first = l.main.variable("first", l.dint), second = l.main.variable("second", l.dint);
      const Word a = turned ? second : first, c = turned ? first : second;
      const Word bit = l.main.frame("bit", l.dint), odd = l.main.frame("odd", l.b.boolean());
      l.main.op(Opcode::kAnd32, {bit, l.i, l.number(3)});
      l.main.op(Opcode::kEq32, {odd, bit, l.number(1)});
      const std::uint32_t end = l.main.jump(Opcode::kCondJump, {odd});
      l.main.op(Opcode::kAdd32, {c, c, a});
      l.main.op(Opcode::kAdd32, {a, a, l.number(5)});
      l.main.land(end);
    });
    EXPECT_EQ(loop.report().choices, 1u);
    EXPECT_EQ(value_of(*loop.arranged, turned ? "Main0.second" : "Main0.first"), "75");
    EXPECT_EQ(value_of(*loop.arranged, turned ? "Main0.first" : "Main0.second"), "525");
  }
}

}  // namespace
}  // namespace plc::test
