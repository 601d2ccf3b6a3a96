// Loops whose variables lie in registers: which ones there are, and that nobody notices.
#include "native/loops.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <functional>
#include <initializer_list>
#include <limits>
#include <memory>
#include <span>
#include <thread>
#include <vector>

#include "native/if_conversion.h"
#include "tests/support/engines.h"
#include "tests/support/image_builder.h"
#include "tests/unit/native/loop_support.h"

namespace plc::test {
namespace {

/// The loops of the program.
std::vector<native::Loop> loops_of(Engines& engines) {
  const runtime::LinkedCode& linked = engines[0].program(0).linked();
  std::vector<native::Loop> found;
  for (std::size_t i = 0; i < linked.bodies.size(); ++i) {
    const auto of_body = native::find_loops(linked.data(), linked.instructions_of(i));
    found.insert(found.end(), of_body.begin(), of_body.end());
  }
  return found;
}

/// FOR i := 0 TO last: sum := sum + a[i], and what `inside` adds to it; ARRAY [0..7] OF DINT.
struct Sum {
  explicit Sum(std::int32_t last, const std::function<void(Sum&)>& inside = {}) {
    main.op(Opcode::kMove32, {i, number(0)});
    head = main.here();
    main.path(Opcode::kLoadAt, {element, a, array}, {{bytecode::PathStep::kIndex, i}});
    main.op(Opcode::kAdd32, {sum, sum, element});
    if (inside) inside(*this);
    main.op(Opcode::kLtI32, {more, i, number(last)});
    const std::uint32_t out = main.jump(Opcode::kCondJump, {more});
    main.op(Opcode::kAdd32, {i, i, number(1)});
    main.op(Opcode::kLoopJump, {head});
    main.land(out);
  }
  Word number(std::int32_t value) { return b.constant(TypeId::kDint, value); }

  ImageBuilder b;
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  std::uint32_t dint = b.type(TypeId::kDint);
  std::uint32_t array = b.array(dint, 8);
  Word a = main.variable("a", array);
  Word sum = main.variable("sum", dint);
  Word i = main.variable("i", dint);
  Word element = main.frame("element", dint);
  Word more = main.frame("more", b.boolean());
  std::uint32_t head = 0;
};

TEST(Loops, VariablesAreKeptAndArraysAreNot) {
  Sum s(7);
  const auto engines = load(s.b, s.main);
  const auto loops = loops_of(*engines);
  ASSERT_EQ(loops.size(), 1u);
  // sum, i, element, more, and two constants
  EXPECT_EQ(loops[0].variables.size(), 6u);
  EXPECT_EQ(std::count_if(loops[0].variables.begin(), loops[0].variables.end(),
                          [](const native::LoopVariable& v) { return v.written; }),
            4);
  EXPECT_TRUE(
      std::is_sorted(loops[0].variables.begin(), loops[0].variables.end(),
                     [](const native::LoopVariable& x, const native::LoopVariable& y) { return x.weight > y.weight; }));
}

TEST(Loops, ElementsOutsideAreEventsAndZero) {
  Sum s(20);  // 13 indices too far
  const auto engines = load(s.b, s.main);
  for (int scan = 0; scan < 3; ++scan) ASSERT_EQ(engines->scan(scan * kPeriodNs), "");
  EXPECT_EQ((*engines)[1].program(0).event_total(), 3u * 13u);
}

TEST(Loops, OneThatSomebodyJumpsIntoIsNone) {
  Sum s(7);
  // Once more, past the head: from after the first one, into a second one.
  const std::uint32_t into = s.main.jump(Opcode::kJump);
  const std::uint32_t head = s.main.here();
  s.main.op(Opcode::kAdd32, {s.sum, s.sum, s.number(1)});
  s.main.land(into);
  s.main.op(Opcode::kLtI32, {s.more, s.sum, s.number(100)});
  const std::uint32_t out = s.main.jump(Opcode::kCondJump, {s.more});
  s.main.op(Opcode::kLoopJump, {head});
  s.main.land(out);
  const auto engines = load(s.b, s.main);
  EXPECT_EQ(loops_of(*engines).size(), 1u);
  for (int scan = 0; scan < 3; ++scan) ASSERT_EQ(engines->scan(scan * kPeriodNs), "");
}

TEST(Loops, TheBudgetEndsThemInTheSameRound) {
  for (const std::uint32_t budget : {1u, 64u, 255u, 256u, 257u, 512u, 1000u}) {
    Sum s(600);
    const auto engines = load(s.b, s.main, budget);
    ASSERT_EQ(engines->scan(0), "") << budget;
    EXPECT_EQ(engines->fault().kind, budget < 600 ? runtime::FaultKind::kLoopBudget : runtime::FaultKind::kNone)
        << budget;
  }
}

/// FOR i := first TO last BY step (down: -step): sum := sum + i; of 16 or 32 bits.
struct Count {
  bool wide = true, down = false;
  std::int32_t first = 0, last = 0, step = 1;
  bool limit_is_variable = false;
};
std::unique_ptr<Engines> load(const Count& count, std::uint32_t budget) {
  ImageBuilder b;
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  const TypeId type = count.wide ? TypeId::kDint : TypeId::kInt;
  const auto number = [&](std::int32_t value) {
    return count.wide ? b.constant(type, value) : b.constant(type, static_cast<std::int16_t>(value));
  };
  const Word sum = main.variable("sum", b.type(type));
  const Word i = main.variable("i", b.type(type));
  const Word limit = main.variable("limit", b.type(type));
  const Word more = main.frame("more", b.boolean());
  const auto op = [&](Opcode of_32, Opcode of_16, std::initializer_list<Word> operands) {
    main.op(count.wide ? of_32 : of_16, operands);
  };
  op(Opcode::kMove32, Opcode::kMove16, {limit, number(count.last)});
  op(Opcode::kMove32, Opcode::kMove16, {i, number(count.first)});
  const std::uint32_t head = main.here();
  op(Opcode::kAdd32, Opcode::kAdd16, {sum, sum, i});
  op(count.down ? Opcode::kGtI32 : Opcode::kLtI32, count.down ? Opcode::kGtI16 : Opcode::kLtI16,
     {more, i, count.limit_is_variable ? limit : number(count.last)});
  const std::uint32_t out = main.jump(Opcode::kCondJump, {more});
  op(count.down ? Opcode::kSub32 : Opcode::kAdd32, count.down ? Opcode::kSub16 : Opcode::kAdd16,
     {i, i, number(count.step)});
  main.op(Opcode::kLoopJump, {head});
  main.land(out);
  return load(b, main, budget);
}

TEST(Loops, SeveralRoundsAtOnceEndWhereSingleOnesDo) {
  for (const bool wide : {false, true}) {
    const std::int32_t most =
        wide ? std::numeric_limits<std::int32_t>::max() : std::numeric_limits<std::int16_t>::max();
    const std::int32_t least = -most - 1;
    std::vector<Count> counts;
    for (const std::int32_t step : {1, 3, 7}) {
      for (std::int32_t rounds = 0; rounds < 20; ++rounds) {
        counts.push_back({wide, false, -5, -5 + rounds, step});
        counts.push_back({wide, true, 5, 5 - rounds, step});
        // Past the end of the type they continue at its other end, until the budget is used up.
        counts.push_back({wide, false, most - rounds, most, step});
        counts.push_back({wide, true, least + rounds, least, step});
        counts.push_back({wide, false, least, least + rounds, step});
        counts.push_back({wide, true, most, most - rounds, step});
      }
    }
    for (Count count : counts) {
      for (const bool variable : {false, true}) {
        count.limit_is_variable = variable;
        for (const std::uint32_t budget : {1u, 2u, 3u, 4u, 5u, 8u, 100u}) {
          const auto engines = load(count, budget);
          const auto loops = loops_of(*engines);
          ASSERT_EQ(loops.size(), 1u);
          EXPECT_TRUE(loops[0].inner.at(0).counts);
          for (int scan = 0; scan < 2; ++scan) {
            ASSERT_EQ(engines->scan(scan * kPeriodNs), "") << count.first << " to " << count.last << ", " << budget;
          }
        }
      }
    }
  }
}

/// x := x + 1.5 and a[i] := x, then sum := sum + factor * a[i], FOR i := 0 TO last; ARRAY [0..15] OF REAL.
enum class Reads { kSecond, kFirst, kBoth, kElsewhereToo };
std::unique_ptr<Engines> load_products(std::int32_t last, Reads reads, std::uint32_t budget) {
  ImageBuilder b;
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  const std::uint32_t real = b.type(TypeId::kReal), dint = b.type(TypeId::kDint), array = b.array(real, 16);
  const Word a = main.variable("a", array), sum = main.variable("sum", real), x = main.variable("x", real);
  const Word i = main.variable("i", dint), factor = main.variable("factor", real);
  const Word element = main.frame("element", real), product = main.frame("product", real);
  const Word more = main.frame("more", b.boolean());
  const auto for_i = [&](const std::function<void()>& inside) {
    main.op(Opcode::kMove32, {i, b.constant(TypeId::kDint, std::int32_t{0})});
    const std::uint32_t head = main.here();
    inside();
    main.op(Opcode::kLtI32, {more, i, b.constant(TypeId::kDint, last)});
    const std::uint32_t out = main.jump(Opcode::kCondJump, {more});
    main.op(Opcode::kAdd32, {i, i, b.constant(TypeId::kDint, std::int32_t{1})});
    main.op(Opcode::kLoopJump, {head});
    main.land(out);
  };
  main.op(Opcode::kAddF32, {factor, factor, b.constant(TypeId::kReal, 0.75f)});
  for_i([&] {
    main.op(Opcode::kAddF32, {x, x, b.constant(TypeId::kReal, 1.5f)});
    main.path(Opcode::kStoreAt, {a, x, array}, {{bytecode::PathStep::kIndex, i}});
  });
  for_i([&] {
    main.path(Opcode::kLoadAt, {element, a, array}, {{bytecode::PathStep::kIndex, i}});
    main.op(Opcode::kMulF32, {product, reads == Reads::kFirst || reads == Reads::kBoth ? element : factor,
                              reads == Reads::kFirst ? factor : element});
    main.op(Opcode::kAddF32, {sum, sum, reads == Reads::kElsewhereToo ? element : product});
  });
  return load(b, main, budget);
}

TEST(Loops, AnElementGoesStraightIntoArithmeticButIsThereAfterTheLoop) {
  for (const Reads reads : {Reads::kSecond, Reads::kFirst, Reads::kBoth, Reads::kElsewhereToo}) {
    for (std::int32_t last = 0; last < 20; ++last) {  // from 16 on, indices outside
      for (const std::uint32_t budget : {3u, 20u, 24u, 25u, 26u, 27u, 28u, 1000u}) {
        const auto engines = load_products(last, reads, budget);
        for (int scan = 0; scan < 2; ++scan) {
          ASSERT_EQ(engines->scan(scan * kPeriodNs), "") << static_cast<int>(reads) << ' ' << last << ' ' << budget;
        }
      }
    }
  }
}

TEST(Loops, OnesThatAreLeftElsewhereRunRoundByRound) {
  Sum s(20, [](Sum& sum) {
    sum.main.op(Opcode::kLtI32, {sum.more, sum.sum, sum.number(9)});
    const std::uint32_t out = sum.main.jump(Opcode::kCondJump, {sum.more});
    sum.main.land(out);
  });
  const auto engines = load(s.b, s.main, 10);
  ASSERT_EQ(loops_of(*engines).size(), 1u);
  EXPECT_FALSE(loops_of(*engines)[0].inner.at(0).counts);
  EXPECT_EQ(engines->scan(0), "");
}

TEST(Loops, OthersCutThemWithinAPortion) {
  ImageBuilder b;
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  const Word n = main.variable("n", b.type(TypeId::kUdint));
  const std::uint32_t head = main.here();
  main.op(Opcode::kAdd32, {n, n, b.constant(TypeId::kUdint, std::uint32_t{1})});
  main.op(Opcode::kLoopJump, {head});
  const auto engines = load(b, main, 0xffffffffu);
  runtime::Program& program = (*engines)[1].program(0);
  std::atomic<bool> ended{false};
  const std::jthread other([&] {
    while (!ended) program.cut_loops();
  });
  EXPECT_EQ(program.execute({0}).kind, runtime::FaultKind::kLoopBudget);
  ended = true;
  std::uint32_t rounds = 0;
  std::memcpy(&rounds, program.table().data() + program.table().layout().instance, sizeof rounds);
  EXPECT_LT(rounds, 0xffffffffu);
}

/// What follows IF element > 3 THEN i2 := i2 + 1 ELSE i2 := i2 - 1 END_IF, and the same with a store.
TEST(Loops, AChoiceOfIntegersIsMadeWithoutAJump) {
  const auto with_if = [](bool stores) {
    return [stores](Sum& s) {
      s.main.op(Opcode::kGtI32, {s.more, s.element, s.number(3)});
      const std::uint32_t otherwise = s.main.jump(Opcode::kCondJump, {s.more});
      s.main.op(Opcode::kAdd32, {s.sum, s.sum, s.number(1)});
      if (stores) s.main.path(Opcode::kStoreAt, {s.a, s.sum, s.array}, {{bytecode::PathStep::kIndex, s.i}});
      const std::uint32_t end = s.main.jump(Opcode::kJump);
      s.main.land(otherwise);
      s.main.op(Opcode::kSub32, {s.sum, s.sum, s.number(2)});
      s.main.land(end);
    };
  };
  for (const bool stores : {false, true}) {
    Sum s(7, with_if(stores));
    const auto engines = load(s.b, s.main);
    const runtime::LinkedCode& linked = (*engines)[0].program(0).linked();
    std::size_t short_ifs = 0;
    for (std::size_t i = 0; i + 1 < linked.instructions.size(); ++i) {
      const auto short_if = native::short_if_at(linked.data(), linked.instructions, i, [&](std::uint32_t position) {
        return static_cast<std::size_t>(
            std::count_if(linked.instructions.begin(), linked.instructions.end(), [&](const auto& instruction) {
              return native::target_of(native::operation_of(instruction.op).form,
                                       linked.data() + instruction.position) == position;
            }));
      });
      if (!short_if || short_if->other.first == short_if->other.last) continue;
      ++short_ifs;
      EXPECT_TRUE(short_if->value);
      EXPECT_EQ(short_if->taken.last - short_if->taken.first, stores ? 2u : 1u);
      EXPECT_EQ(short_if->other.last - short_if->other.first, 1u);
    }
    EXPECT_EQ(short_ifs, 1u);
    for (int scan = 0; scan < 20; ++scan) {
      for (std::size_t e = 0; e < engines->size(); ++e) {
        runtime::Program& program = (*engines)[e].program(0);
        std::byte* const elements = program.table().data() + program.table().layout().instance;
        for (int k = 0; k < 8; ++k) elements[4 * k] = static_cast<std::byte>((scan * 5 + k * 3) % 8);
      }
      ASSERT_EQ(engines->scan(scan * kPeriodNs), "") << scan;
    }
  }
}

TEST(Accesses, PartsWithSeveralIndicesEndWithTheLastOne) {
  ImageBuilder b;
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  const std::uint32_t dint = b.type(TypeId::kDint);
  const std::uint32_t inner = b.array(dint, 3);
  const std::uint32_t pair = b.structure("Pair", {{"x", inner}, {"y", inner}});
  const std::uint32_t outer = b.array(pair, 2);
  const Word i = main.variable("i", dint);
  const Word value = main.variable("value", dint);
  const Word a = main.variable("a", outer);
  main.path(Opcode::kLoadAt, {value, a, outer},
            {{bytecode::PathStep::kIndex, i}, {bytecode::PathStep::kField, 1}, {bytecode::PathStep::kIndex, i}});
  const auto engines = load(b, main);
  const runtime::LinkedCode& linked = (*engines)[0].program(0).linked();
  for (const runtime::LinkedInstruction& instruction : linked.instructions) {
    if (instruction.op != runtime::ResolvedOp::kLoadPath32) continue;
    const auto found = native::accesses_of(linked.data(), {linked.data() + instruction.position, instruction.position,
                                                           native::operation_of(instruction.op)});
    ASSERT_TRUE(found.has_value());
    ASSERT_EQ(found->size(), 4u);
    EXPECT_TRUE(found->front().write);
    EXPECT_EQ(found->back().operand, found->front().operand + 4 + 12);  // a[0].y[0]
    EXPECT_EQ(found->back().bytes, 24u + 8u + 4u);                      // to a[1].y[2]
    return;
  }
  FAIL() << "no LoadPath32";
}

/// In a loop: what `body` adds, which may leave the loop, and a loop of so many numbers that variables which are used
/// less have no registers left. Ends with the budget.
std::unique_ptr<Engines> load_crowded(ImageBuilder& b, PouBuilder& main, TypeId type, Opcode subtract, Word step,
                                      const std::function<std::vector<std::uint32_t>(const std::vector<Word>&)>& body) {
  std::vector<Word> numbers;
  for (int n = 0; n < 20; ++n) numbers.push_back(main.variable("number" + std::to_string(n), b.type(type)));
  const Word going = main.variable("going", b.boolean());
  const std::uint32_t outer = main.here();
  const std::vector<std::uint32_t> exits = body(numbers);
  const std::uint32_t inner = main.here();
  for (int round = 0; round < 2; ++round) {
    for (const Word number : numbers) main.op(subtract, {number, number, step});
  }
  const std::uint32_t out = main.jump(Opcode::kCondJump, {going});
  main.op(Opcode::kLoopJump, {inner});
  main.land(out);
  main.op(Opcode::kLoopJump, {outer});
  for (const std::uint32_t exit : exits) main.land(exit);
  return load(b, main, 5);
}

/// `copy` := `counts`, whose register is the loop's, and then a result that needs a register for itself.
void copy_then_compute(Opcode move, Opcode subtract, TypeId type, std::vector<std::byte> step) {
  ImageBuilder b;
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  const std::uint32_t number = b.type(type);
  const Word counts = main.variable("counts", number, FieldRole::kLocal, std::move(step));
  const Word copy = main.variable("copy", number), result = main.variable("result", number);
  const auto engines = load_crowded(b, main, type, subtract, counts, [&](const std::vector<Word>& numbers) {
    main.op(move, {copy, counts});
    main.op(subtract, {result, copy, numbers[0]});
    return std::vector<std::uint32_t>{};
  });
  ASSERT_NE(engines, nullptr);
  for (int scan = 1; scan <= 3; ++scan) EXPECT_EQ(engines->scan(scan * kPeriodNs), "");
}

TEST(Loops, ACopyDoesNotLendTheRegisterOfWhatItCopies) {
  copy_then_compute(Opcode::kMove64, Opcode::kSub64, TypeId::kLint, bytes_of(std::int64_t{3}));
  copy_then_compute(Opcode::kMove32, Opcode::kSub32, TypeId::kDint, bytes_of(std::int32_t{3}));
  copy_then_compute(Opcode::kMoveF64, Opcode::kSubF64, TypeId::kLreal, bytes_of(3.0));
  copy_then_compute(Opcode::kMoveF32, Opcode::kSubF32, TypeId::kReal, bytes_of(3.0f));
}

TEST(Loops, AComparisonOfRealsLosesWhatIsHeld) {
  // WHILE x = y AND i < n: n has just been made 0, in a register that the first comparison needs.
  ImageBuilder b;
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  const std::uint32_t dint = b.type(TypeId::kDint), real = b.type(TypeId::kReal);
  const Word i = main.variable("i", dint), n = main.variable("n", dint);
  const Word x = main.variable("x", real), y = main.variable("y", real);
  const Word more = main.frame("more", b.boolean());
  const Word step = b.constant(TypeId::kDint, std::int32_t{1});
  const auto engines = load_crowded(b, main, TypeId::kDint, Opcode::kSub32, step, [&](const std::vector<Word>& of) {
    main.op(Opcode::kSub32, {n, of[0], of[1]});
    main.op(Opcode::kEqF32, {more, x, y});
    const std::uint32_t other = main.jump(Opcode::kCondJump, {more});
    main.op(Opcode::kLtI32, {more, i, n});
    return std::vector{other, main.jump(Opcode::kCondJump, {more})};
  });
  ASSERT_NE(engines, nullptr);
  EXPECT_EQ(engines->scan(kPeriodNs), "");
  EXPECT_FALSE(engines->fault());
}

TEST(Loops, APortOfTheBlockAfterOneIsAVariableOfIt) {
  ImageBuilder b;
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  const std::uint32_t boolean = b.boolean(), dint = b.type(TypeId::kDint);
  const Word block = main.variable("rs", b.block_type("RS")), n = main.variable("n", dint);
  const Word set = block;  // its first port
  const Word more = main.frame("more", boolean);
  const std::uint32_t head = main.here();
  main.op(Opcode::kLtI32, {more, n, b.constant(TypeId::kDint, std::int32_t{5})});
  const std::uint32_t out = main.jump(Opcode::kCondJump, {more});
  main.op(Opcode::kAdd32, {n, n, b.constant(TypeId::kDint, std::int32_t{1})});
  main.op(Opcode::kMoveBool, {set, b.constant(TypeId::kBool, std::uint8_t{1})});
  main.op(Opcode::kLoopJump, {head});
  main.land(out);
  main.op(Opcode::kRunTb, {b.block("RS"), block});
  const auto engines = load(b, main);
  ASSERT_NE(engines, nullptr);
  ASSERT_EQ(loops_of(*engines).size(), 1u);
  EXPECT_EQ(engines->scan(kPeriodNs), "");
}

/// x and y: ARRAY [0..11, 0..11] of numbers.
struct Matrices {
  Matrices() {
    std::array<float, 144> numbers{};
    for (int n = 0; n < 144; ++n) numbers[static_cast<std::size_t>(n)] = static_cast<float>(n * n % 37 - 11) / 4;
    x = main.variable("x", rows, FieldRole::kLocal, bytes_of(numbers));
    y = main.variable("y", rows, FieldRole::kLocal, bytes_of(numbers));
  }
  Word number(std::int32_t value) { return b.constant(TypeId::kDint, value); }
  void load(Word value, Word array, Word first, Word second) {
    main.path(Opcode::kLoadAt, {value, array, rows},
              {{bytecode::PathStep::kIndex, first}, {bytecode::PathStep::kIndex, second}});
  }
  void store(Word array, Word value, Word first, Word second) {
    main.path(Opcode::kStoreAt, {array, value, rows},
              {{bytecode::PathStep::kIndex, first}, {bytecode::PathStep::kIndex, second}});
  }
  void for_each(Word counter, std::int32_t last, std::int32_t step, const std::function<void()>& inside) {
    main.op(Opcode::kMove32, {counter, number(0)});
    const std::uint32_t head = main.here();
    inside();
    main.op(Opcode::kLtI32, {more, counter, number(last)});
    const std::uint32_t out = main.jump(Opcode::kCondJump, {more});
    main.op(Opcode::kAdd32, {counter, counter, number(step)});
    main.op(Opcode::kLoopJump, {head});
    main.land(out);
  }
  void run() {
    const auto engines = plc::test::load(b, main, 100'000);
    ASSERT_NE(engines, nullptr);
    for (int scan = 0; scan < 2; ++scan) EXPECT_EQ(engines->scan(scan * kPeriodNs), "");
    EXPECT_FALSE(engines->fault());
  }

  ImageBuilder b;
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  std::uint32_t dint = b.type(TypeId::kDint), real = b.type(TypeId::kReal);
  std::uint32_t row = b.array(real, 12), rows = b.array(row, 12);
  Word x = 0, y = 0, z = main.variable("z", rows);
  Word i = main.variable("i", dint), j = main.variable("j", dint), k = main.variable("k", dint);
  Word f = main.frame("f", real), g = main.frame("g", real), more = main.frame("more", b.boolean());
};

TEST(Loops, AProductOfMatrices) {
  // Rows of one by what the loop counts, of the other by what it does not change.
  for (const std::int32_t step : {1, 2, 3}) {
    Matrices m;
    const Word sum = m.main.variable("sum", m.real);
    m.for_each(m.i, 11, 1, [&] {
      m.for_each(m.j, 11, 1, [&] {
        m.main.op(Opcode::kMoveF32, {sum, m.b.constant(TypeId::kReal, 0.5f)});
        m.for_each(m.k, 11 / step * step, step, [&] {
          m.load(m.f, m.x, m.i, m.k);
          m.load(m.g, m.y, m.k, m.j);
          m.main.op(Opcode::kMulF32, {m.f, m.f, m.g});
          m.main.op(Opcode::kAddF32, {sum, sum, m.f});
        });
        m.store(m.z, sum, m.i, m.j);
      });
    });
    m.run();
  }
}

TEST(Loops, ARowIsAnotherOneWhenItsIndexIs) {
  // x[i, k], and the same where i has become something else, and where it is what it was.
  for (const std::int32_t added : {-1, 1, 2}) {
    Matrices m;
    const Word was = m.main.variable("was", m.dint);
    m.for_each(m.k, 11, 1, [&] {
      const auto swap = [&](Word array) {
        m.load(m.f, array, m.i, m.k);
        m.store(m.z, m.f, m.k, m.i);
      };
      m.main.op(Opcode::kMove32, {m.i, m.number(3)});
      swap(m.x);
      m.main.op(Opcode::kAdd32, {m.i, m.i, m.number(added)});
      swap(m.x);
      m.main.op(Opcode::kSub32, {m.i, m.i, m.number(added)});
      swap(m.y);
      m.main.op(Opcode::kMove32, {m.i, m.number(9)});
      swap(m.x);
      m.main.op(Opcode::kMove32, {was, m.i});
      m.main.op(Opcode::kMove32, {m.i, was});
      swap(m.y);
    });
    m.run();
  }
}

TEST(Loops, AnAddressOfARowLosesWhatIsHeld) {
  // x[i, n]: n is held, in one of two registers, where the address of row i is made, since i has only 16 bits.
  for (const bool other_register : {false, true}) {
    Matrices m;
    const std::uint32_t integer = m.b.type(TypeId::kInt);
    const Word i = m.main.variable("small", integer);
    const Word n = m.main.frame("n", integer), t = m.main.frame("t", integer);
    const auto number = [&m](std::int16_t value) { return m.b.constant(TypeId::kInt, value); };
    m.main.op(Opcode::kMove16, {i, number(0)});
    const std::uint32_t head = m.main.here();
    for (int other = 0; other < 5; ++other) {  // they use up registers
      const Word variable = m.main.variable("other" + std::to_string(other), integer);
      for (int time = 0; time < 3; ++time) m.main.op(Opcode::kAdd16, {variable, variable, i});
    }
    if (other_register) m.main.op(Opcode::kAdd16, {t, i, number(5)});
    m.main.op(Opcode::kAdd16, {n, i, number(1)});
    m.load(m.g, m.x, i, n);
    m.main.op(Opcode::kLtI16, {m.more, i, number(10)});
    const std::uint32_t out = m.main.jump(Opcode::kCondJump, {m.more});
    m.main.op(Opcode::kAdd16, {i, i, number(1)});
    m.main.op(Opcode::kLoopJump, {head});
    m.main.land(out);
    m.run();
  }
}

}  // namespace
}  // namespace plc::test
