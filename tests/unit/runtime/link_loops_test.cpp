// Counted loops that the interpreter runs instruction by instruction: which ones, and that nobody sees it. Random
// programs: tests/engines.
#include <functional>
#include <vector>

#include "tests/unit/runtime/run_support.h"

namespace plc::test {
namespace {

using bytecode::Opcode;
using core::TypeId;

/// FOR i := first TO last BY step: arrays x (DINT), y (DINT), r (REAL), all [0..99]; x and r hold numbers.
class CountedLoop {
 public:
  using Body = std::function<void(CountedLoop&)>;
  CountedLoop(std::int32_t first, std::int32_t last, const Body& body, std::int32_t step = 1) {
    std::vector<std::byte> numbers(400), fractions(400);
    for (int n = 0; n < 100; ++n) {
      const std::int32_t number = n * 7 % 31 - 9;
      const float fraction = static_cast<float>(number) / 4;
      std::memcpy(numbers.data() + n * 4, &number, 4);
      std::memcpy(fractions.data() + n * 4, &fraction, 4);
    }
    x = main.variable("x", dints, bytecode::FieldRole::kLocal, numbers);
    y = main.variable("y", dints);
    r = main.variable("r", b.array(real, 100), bytecode::FieldRole::kLocal, fractions);
    i = main.variable("i", dint);
    main.op(Opcode::kMove32, {i, number(first)});
    const std::uint32_t head = main.here();
    body(*this);
    const Word more = main.frame("more", b.boolean());
    main.op(step > 0 ? Opcode::kLtI32 : Opcode::kGtI32, {more, i, number(last)});
    const std::uint32_t out = main.jump(Opcode::kCondJump, {more});
    main.op(step > 0 ? Opcode::kAdd32 : Opcode::kSub32, {i, i, number(step > 0 ? step : -step)});
    main.op(Opcode::kLoopJump, {head});
    main.land(out);
    main.op(Opcode::kAdd32, {main.variable("behind", dint), i, number(1)});
    b.task("Cyclic", 10'000'000, {main.finish()});
  }

  /// Runs three scans with and without loop runs: the same bytes, faults and events. Returns how many loops were runs.
  std::uint64_t run(std::uint32_t budget = 10'000) {
    runtime::ProgramOptions options;
    options.loop_budget = budget;
    arranged = load(b, options);
    options.arrange = false;
    plain = load(b, options);
    if (arranged == nullptr || plain == nullptr) return 0;
    for (int scan = 0; scan < 3; ++scan) {
      fault = arranged->program(0).execute({});
      const runtime::Fault expected = plain->program(0).execute({});
      EXPECT_EQ(fault.kind, expected.kind);
      EXPECT_EQ(fault.word, expected.word);
      const std::uint64_t bytes = arranged->program(0).table().layout().total;
      EXPECT_EQ(std::memcmp(arranged->program(0).table().data(), plain->program(0).table().data(), bytes), 0);
      EXPECT_EQ(arranged->program(0).event_total(), plain->program(0).event_total());
    }
    EXPECT_EQ(plain->program(0).link_report().loops, 0u);
    return arranged->program(0).link_report().loops;
  }

  Word number(std::int32_t value) { return b.constant(TypeId::kDint, value); }
  Word temporary(TypeId id = TypeId::kDint) { return main.frame("t" + std::to_string(made_++), b.type(id)); }
  Word sum(Opcode op, Word a, Word c) {
    const Word out = temporary();
    main.op(op, {out, a, c});
    return out;
  }
  Word load_from(Word array, Word index, TypeId id = TypeId::kDint) {
    const Word out = temporary(id);
    main.path(Opcode::kLoadAt, {out, array, id == TypeId::kReal ? reals : dints},
              {{bytecode::PathStep::kIndex, index}});
    return out;
  }
  void store_to(Word array, Word index, Word value) {
    main.path(Opcode::kStoreAt, {array, value, dints}, {{bytecode::PathStep::kIndex, index}});
  }

  ImageBuilder b;
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  std::uint32_t dint = b.type(TypeId::kDint), real = b.type(TypeId::kReal);
  std::uint32_t dints = b.array(dint, 100), reals = b.array(real, 100);
  Word x = 0, y = 0, r = 0, i = 0;
  std::unique_ptr<runtime::Resource> arranged, plain;
  runtime::Fault fault;

 private:
  int made_ = 0;
};

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
