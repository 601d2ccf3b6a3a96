// Counted loops that the interpreter runs instruction by instruction: which ones, and that nobody sees it. Random
// programs: tests/engines.
#include <gtest/gtest.h>

#include "tests/unit/runtime/counted_loop.h"

namespace plc::test {
namespace {

TEST(LoopRuns, ASumOfProducts) {
  CountedLoop loop(0, 31, [](CountedLoop& l) {
    const Word total = l.main.variable("total", l.real);
    const Word product = l.temporary(TypeId::kReal);
    const Word ahead = l.sum(Opcode::kAdd32, l.i, l.number(20));
    const Word a = l.load_from(l.r, l.i, TypeId::kReal), c = l.load_from(l.r, ahead, TypeId::kReal);
    l.main.op(Opcode::kMulF32, {product, a, c});
    l.main.op(Opcode::kAddF32, {total, total, product});
  });
  EXPECT_EQ(loop.run(), 1u);
  EXPECT_EQ(value_of(*loop.arranged, "Main0.behind"), "32");
}

TEST(LoopRuns, WhatTheLastRoundLeavesInVariables) {
  // Of each kind: an element, a value that nobody reads, one of such a value, one that goes straight into an array, one
  // that another overwrites.
  CountedLoop loop(0, 70, [](CountedLoop& l) {
    const auto keep = [&l](const char* name, Opcode op, Word a, Word c) {
      const Word out = l.main.variable(name, l.dint);
      l.main.op(op, {out, a, c});
      return out;
    };
    const Word element = l.load_from(l.x, l.i);
    const Word unread = keep("unread", Opcode::kAdd32, element, l.number(1000));
    keep("of_unread", Opcode::kMul32, unread, l.i);
    l.store_to(l.y, l.i, keep("stored", Opcode::kSub32, element, l.i));
    const Word twice = l.main.variable("twice", l.dint);
    l.main.op(Opcode::kAdd32, {twice, element, l.number(5)});
    keep("of_twice", Opcode::kMul32, twice, l.number(2));
    l.main.op(Opcode::kMove32, {twice, l.i});
  });
  EXPECT_EQ(loop.run(), 1u);
  // x[70] is 490 mod 31 - 9 = 16.
  EXPECT_EQ(value_of(*loop.arranged, "Main0.unread"), "1016");
  EXPECT_EQ(value_of(*loop.arranged, "Main0.of_unread"), "71120");
  EXPECT_EQ(value_of(*loop.arranged, "Main0.stored"), "-54");
  EXPECT_EQ(value_of(*loop.arranged, "Main0.of_twice"), "42");
  EXPECT_EQ(value_of(*loop.arranged, "Main0.twice"), "70");
}

TEST(LoopRuns, AnElementThatIsWrittenTwice) {
  CountedLoop loop(0, 30, [](CountedLoop& l) {
    const Word once = l.main.variable("once", l.dint), element = l.load_from(l.x, l.i);
    l.main.op(Opcode::kAdd32, {once, element, l.number(100)});
    l.store_to(l.y, l.i, once);
    l.store_to(l.y, l.i, l.sum(Opcode::kMul32, element, l.number(2)));
  });
  EXPECT_EQ(loop.run(), 1u);
  // x[30] is 210 mod 31 - 9 = 15.
  EXPECT_EQ(value_of(*loop.arranged, "Main0.once"), "115");
  EXPECT_EQ(value_of(*loop.arranged, "Main0.y[30]"), "30");
}

TEST(LoopRuns, MoreRoundsThanAreRunAtOnce) {
  CountedLoop loop(0, 99,
                   [](CountedLoop& l) { l.store_to(l.y, l.i, l.sum(Opcode::kMul32, l.load_from(l.x, l.i), l.i)); });
  EXPECT_EQ(loop.run(), 1u);
  EXPECT_EQ(value_of(*loop.arranged, "Main0.y[70]"), "1120") << "(490 mod 31 - 9) * 70";
}

TEST(LoopRuns, DownAndBySteps) {
  const auto copy = [](CountedLoop& l) { l.store_to(l.y, l.i, l.load_from(l.x, l.i)); };
  CountedLoop down(99, 0, copy, -1), three(0, 97, copy, 3);
  EXPECT_EQ(down.run(), 1u);
  EXPECT_EQ(three.run(), 1u);
  EXPECT_EQ(value_of(*three.arranged, "Main0.y[96]"), value_of(*three.arranged, "Main0.x[96]"));
  EXPECT_EQ(value_of(*three.arranged, "Main0.y[97]"), "0");
}

TEST(LoopRuns, RoundsOfConstantsAndOfVariables) {
  struct Case {
    std::int32_t first, last, step;
    const char* behind;
  };
  // From all of the array to one round, and to limits that are behind already.
  for (const Case& c : {Case{0, 99, 1, "100"}, Case{99, 0, -1, "1"}, Case{0, 97, 3, "100"}, Case{2, 9, 1, "10"},
                        Case{9, 9, 1, "10"}, Case{9, 3, 1, "10"}, Case{3, 9, -1, "4"}, Case{90, 130, 1, "131"}}) {
    for (const auto rounds : {CountedLoop::Rounds::kConstant, CountedLoop::Rounds::kVariable}) {
      CountedLoop loop(
          c.first, c.last, [](CountedLoop& l) { l.store_to(l.y, l.i, l.load_from(l.x, l.i)); }, c.step, rounds);
      EXPECT_EQ(loop.run(), 1u);
      EXPECT_EQ(value_of(*loop.arranged, "Main0.behind"), c.behind) << c.first << " to " << c.last;
    }
  }
}

TEST(LoopRuns, IndicesOfEveryKind) {
  for (const auto rounds : {CountedLoop::Rounds::kConstant, CountedLoop::Rounds::kVariable}) {
    CountedLoop loop(
        0, 9,
        [](CountedLoop& l) {
          const std::uint32_t row = l.b.array(l.dint, 10), rows = l.b.array(row, 10);
          std::vector<std::byte> numbers(400);
          for (std::size_t n = 0; n < 100; ++n) numbers[n * 4] = static_cast<std::byte>(n);
          const Word table = l.main.variable("table", rows, bytecode::FieldRole::kLocal, numbers);
          const Word line = l.variable("line", 3);
          const Word column = l.main.variable("column", l.b.type(TypeId::kInt), bytecode::FieldRole::kLocal,
                                              {std::byte{6}, std::byte{0}});
          const auto element = [&](Word first, Word second) {
            const Word out = l.temporary();
            l.main.path(Opcode::kLoadAt, {out, table, rows},
                        {{bytecode::PathStep::kIndex, first}, {bytecode::PathStep::kIndex, second}});
            return out;
          };
          Word total = l.sum(Opcode::kAdd32, element(line, l.i), element(l.i, column));
          for (const Word other : {element(l.number(5), l.i), element(l.i, l.i), element(l.number(1), column),
                                   l.load_from(l.x, l.sum(Opcode::kAdd32, l.i, line)), l.load_from(l.x, l.number(7)),
                                   l.load_from(l.x, l.sum(Opcode::kMul32, l.i, l.number(11)))}) {
            total = l.sum(Opcode::kAdd32, total, other);
          }
          l.store_to(l.y, l.i, total);
        },
        1, rounds);
    EXPECT_EQ(loop.run(), 1u);
    // 34 + 46 + 54 + 44 + 16, and x[7], x[7], x[44]: 9, 9, 20.
    EXPECT_EQ(value_of(*loop.arranged, "Main0.y[4]"), "232");
  }
}

TEST(LoopRuns, ValuesMoveDownButNotUp) {
  // In x[i] := x[i + 1] each round reads what the next one writes; in x[i] := x[i - 1] what the one before has written.
  CountedLoop shift(
      0, 60, [](CountedLoop& l) { l.store_to(l.x, l.i, l.load_from(l.x, l.sum(Opcode::kAdd32, l.i, l.number(1)))); });
  EXPECT_EQ(shift.run(), 1u);
  CountedLoop spread(
      1, 60, [](CountedLoop& l) { l.store_to(l.x, l.i, l.load_from(l.x, l.sum(Opcode::kSub32, l.i, l.number(1)))); });
  EXPECT_EQ(spread.run(), 0u);
  EXPECT_EQ(value_of(*spread.arranged, "Main0.x[60]"), "-9");
  CountedLoop down(
      60, 1, [](CountedLoop& l) { l.store_to(l.x, l.i, l.load_from(l.x, l.sum(Opcode::kSub32, l.i, l.number(1)))); },
      -1);
  EXPECT_EQ(down.run(), 1u);
}

TEST(LoopRuns, ASumThatSomebodyLooksAtIsNoRun) {
  CountedLoop loop(0, 60, [](CountedLoop& l) {
    const Word total = l.main.variable("total", l.dint);
    l.main.op(Opcode::kAdd32, {total, total, l.load_from(l.x, l.i)});
    l.store_to(l.y, l.i, total);
  });
  EXPECT_EQ(loop.run(), 0u);
}

TEST(LoopRuns, AnIndexThatTheLoopComputesOtherwiseIsNoRun) {
  CountedLoop loop(0, 60, [](CountedLoop& l) { l.store_to(l.y, l.i, l.load_from(l.x, l.load_from(l.x, l.i))); });
  EXPECT_EQ(loop.run(), 0u);
}

TEST(LoopRuns, AnIndexThatLeavesItsArrayRaisesItsEvents) {
  CountedLoop loop(50, 120, [](CountedLoop& l) { l.store_to(l.y, l.i, l.load_from(l.x, l.i)); });
  EXPECT_EQ(loop.run(), 1u);
  EXPECT_EQ(loop.arranged->program(0).event_total(), 3u * 21 * 2);
}

TEST(LoopRuns, AFunctionRaisesItsEventsWhereItStands) {
  CountedLoop loop(0, 80, [](CountedLoop& l) {
    const Word huge = l.temporary(TypeId::kReal), whole = l.temporary();
    l.main.op(Opcode::kMulF32, {huge, l.load_from(l.r, l.i, TypeId::kReal), l.b.constant(TypeId::kReal, 1e9f)});
    l.main.call_std("REAL_TO_DINT:REAL,DINT", whole, {huge});
    l.store_to(l.y, l.i, whole);
  });
  EXPECT_EQ(loop.run(), 1u);
  EXPECT_GT(loop.arranged->program(0).event_total(), 0u);
  const auto events = loop.arranged->program(0).events(), expected = loop.plain->program(0).events();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].word, expected.at(0).word);
  EXPECT_EQ(events[0].count, expected.at(0).count);
}

TEST(LoopRuns, TheBudgetOfAScanHolds) {
  const auto copy = [](CountedLoop& l) { l.store_to(l.y, l.i, l.load_from(l.x, l.i)); };
  for (const std::uint32_t budget : {0u, 3u, 40u, 64u, 65u, 98u}) {
    CountedLoop loop(0, 99, copy);
    EXPECT_EQ(loop.run(budget), 1u);
    EXPECT_EQ(loop.fault.kind, runtime::FaultKind::kLoopBudget) << budget;
    EXPECT_EQ(value_of(*loop.arranged, "Main0.i"), std::to_string(budget + 1)) << "counted, but no jump for it";
  }
  CountedLoop enough(0, 99, copy);
  enough.run(99);
  EXPECT_FALSE(enough.fault);
}

TEST(LoopRuns, TheControlVariableStaysInItsType) {
  // 2147483600 + 3 * 16 is more than a DINT holds: the last value that counts is 2147483645.
  CountedLoop loop(
      2147483600, 2147483647,
      [](CountedLoop& l) {
        const Word total = l.main.variable("total", l.dint);
        l.main.op(Opcode::kAdd32, {total, total, l.i});
      },
      3);
  EXPECT_EQ(loop.run(200), 1u);
}

}  // namespace
}  // namespace plc::test
