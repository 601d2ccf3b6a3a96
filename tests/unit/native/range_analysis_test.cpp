// What code of a loop leaves out: only what nobody could tell.
#include "native/range_analysis.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <iterator>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "tests/support/engines.h"
#include "tests/support/image_builder.h"
#include "tests/unit/native/loop_support.h"

namespace plc::test {
namespace {

constexpr std::uint32_t kStrangeNan = 0xffc12345u;

/// Writes a word of the task's instance in all engines, as somebody outside does between scans.
void write(Engines& engines, std::size_t offset, std::uint32_t value) {
  for (std::size_t e = 0; e < engines.size(); ++e) {
    runtime::Program& program = engines[e].program(0);
    std::memcpy(program.table().data() + program.table().layout().instance + offset, &value, sizeof value);
  }
}
std::uint32_t read(Engines& engines, std::size_t offset) {
  std::uint32_t value = 0;
  runtime::Program& program = engines[1].program(0);
  std::memcpy(&value, program.table().data() + program.table().layout().instance + offset, sizeof value);
  return value;
}

/// One REAL or DINT of the instance per name, at 4 bytes each, and ARRAY [0..7] OF REAL after them.
struct Program {
  Program() {
    for (const char* name : {"sum", "x", "kept"}) reals.push_back(main.variable(name, real));
    i = main.variable("i", dint);
    n = main.variable("n", dint);
    a = main.variable("a", array);
  }
  static constexpr std::size_t kSum = 0, kX = 4, kKept = 8, kN = 16, kA = 20;

  Word number(std::int32_t value) { return b.constant(TypeId::kDint, value); }
  void load_element(Word number_of) {
    main.path(Opcode::kLoadAt, {element, a, array}, {{bytecode::PathStep::kIndex, number_of}});
  }
  void store_element(Word value) { main.path(Opcode::kStoreAt, {a, value, array}, {{bytecode::PathStep::kIndex, i}}); }
  void add(Word to, Word other) { main.op(Opcode::kAddF32, {to, to, other}); }
  /// FOR i := 0 TO last DO inside; END_FOR
  void loop(std::int32_t last, const std::function<void()>& inside) {
    main.op(Opcode::kMove32, {i, number(0)});
    const std::uint32_t head = main.here();
    inside();
    main.op(Opcode::kLtI32, {more, i, number(last)});
    const std::uint32_t out = main.jump(Opcode::kCondJump, {more});
    main.op(Opcode::kAdd32, {i, i, number(1)});
    main.op(Opcode::kLoopJump, {head});
    main.land(out);
  }
  /// Facts of the only loop.
  static native::LoopRanges facts(Engines& engines) {
    runtime::Program& program = engines[0].program(0);
    const runtime::LinkedCode& linked = program.linked();
    const runtime::TaskLayout& layout = program.table().layout();
    const native::Assembly emitter({program.table().data(), layout.constants, layout.instance});
    for (std::size_t n = 0; n < linked.bodies.size(); ++n) {
      const auto body = linked.instructions_of(n);
      for (const native::Loop& loop : native::find_loops(linked.data(), body)) {
        return native::analyse_ranges(emitter, linked.data(), body, loop);
      }
    }
    ADD_FAILURE() << "no loop";
    return {};
  }
  static std::size_t inside(const native::LoopRanges& facts) {
    return static_cast<std::size_t>(std::count_if(facts.instructions.begin(), facts.instructions.end(),
                                                  [](const auto& of) { return of.known.inside != 0; }));
  }
  static std::size_t any_nan(const native::LoopRanges& facts) {
    return static_cast<std::size_t>(std::count_if(facts.instructions.begin(), facts.instructions.end(),
                                                  [](const auto& of) { return of.known.any_nan; }));
  }

  ImageBuilder b;
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  std::uint32_t real = b.type(TypeId::kReal);
  std::uint32_t dint = b.type(TypeId::kDint);
  std::uint32_t array = b.array(real, 8);
  std::vector<Word> reals;
  Word i = 0, n = 0, a = 0;
  Word element = main.frame("element", real);
  Word product = main.frame("product", real);
  Word index = main.frame("index", dint);
  Word more = main.frame("more", b.boolean());
};

TEST(LoopRanges, AnIndexThatCountsWithinTheArrayIsNotChecked) {
  for (const std::int32_t last : {7, 8}) {
    Program p;
    p.loop(last, [&] { p.load_element(p.i); });
    const auto engines = load(p.b, p.main);
    EXPECT_EQ(Program::inside(Program::facts(*engines)), last == 7 ? 1u : 0u);
    ASSERT_EQ(engines->scan(0), "");
    EXPECT_EQ((*engines)[1].program(0).event_total(), last == 7 ? 0u : 1u);
  }
}

TEST(LoopRanges, ASumOfIndicesHasARange) {
  for (const std::int32_t more : {3, 4}) {
    Program p;
    p.loop(4, [&] {
      p.main.op(Opcode::kAdd32, {p.index, p.i, p.number(more)});
      p.load_element(p.index);
    });
    const auto engines = load(p.b, p.main);
    EXPECT_EQ(Program::inside(Program::facts(*engines)), more == 3 ? 1u : 0u);
    ASSERT_EQ(engines->scan(0), "");
  }
}

TEST(LoopRanges, AnIndexThatTheBodyWritesIsChecked) {
  Program p;
  p.loop(7, [&] {
    p.load_element(p.i);
    p.main.op(Opcode::kAdd32, {p.i, p.i, p.n});
  });
  const auto engines = load(p.b, p.main);
  EXPECT_EQ(Program::inside(Program::facts(*engines)), 0u);
  for (const std::uint32_t step : {0u, 3u, 100u, 0xfffffff0u}) {
    write(*engines, Program::kN, step);
    ASSERT_EQ(engines->scan(0), "") << step;
  }
  EXPECT_NE((*engines)[1].program(0).event_total(), 0u);
}

TEST(LoopRanges, AnIndexIsCheckedWhenOthersJumpToTheLoop) {
  Program p;
  p.main.op(Opcode::kMove32, {p.i, p.n});
  p.main.op(Opcode::kLtI32, {p.more, p.n, p.number(0)});
  const std::uint32_t past = p.main.jump(Opcode::kJumpIf, {p.more});
  p.main.op(Opcode::kMove32, {p.i, p.number(0)});
  p.main.land(past);
  const std::uint32_t head = p.main.here();
  p.load_element(p.i);
  p.main.op(Opcode::kLtI32, {p.more, p.i, p.number(7)});
  const std::uint32_t out = p.main.jump(Opcode::kCondJump, {p.more});
  p.main.op(Opcode::kAdd32, {p.i, p.i, p.number(1)});
  p.main.op(Opcode::kLoopJump, {head});
  p.main.land(out);
  const auto engines = load(p.b, p.main);
  EXPECT_EQ(Program::inside(Program::facts(*engines)), 0u);
  write(*engines, Program::kN, 0xfffffffdu);
  ASSERT_EQ(engines->scan(0), "");
  EXPECT_EQ((*engines)[1].program(0).event_total(), 3u);
}

TEST(LoopRanges, ANanIsMadeTheOneWhereSomebodyLooks) {
  Program p;
  p.main.op(Opcode::kMoveF32, {p.reals[0], p.b.constant(TypeId::kReal, 0.0f)});
  p.loop(7, [&] {
    p.load_element(p.i);
    p.main.op(Opcode::kMulF32, {p.product, p.element, p.reals[1]});
    p.add(p.reals[0], p.product);
  });
  const auto engines = load(p.b, p.main);
  const native::LoopRanges facts = Program::facts(*engines);
  // The product. The sum may be strange where the loop is entered, as far as the loop itself says.
  EXPECT_EQ(Program::any_nan(facts), 1u);
  ASSERT_EQ(facts.exits.size(), 1u);
  EXPECT_EQ(facts.exits.begin()->second.reals.size(), 1u);
  EXPECT_EQ(facts.exits.begin()->second.results.size(), 1u);
  for (const std::uint32_t x : {kStrangeNan, 0x7f800000u, 0x3f800000u}) {  // the second: infinity times 0
    write(*engines, Program::kX, x);
    ASSERT_EQ(engines->scan(0), "") << x;
    EXPECT_EQ(read(*engines, Program::kSum), x == 0x3f800000u ? 0u : 0x7fc00000u);
  }
}

TEST(LoopRanges, ANanThatIsStoredOrMovedInTheLoopIsTheOne) {
  Program p;
  p.main.op(Opcode::kMoveF32, {p.reals[0], p.b.constant(TypeId::kReal, 0.0f)});
  p.loop(7, [&] {
    p.add(p.reals[0], p.reals[1]);
    p.store_element(p.reals[0]);
    p.main.op(Opcode::kMoveF32, {p.reals[2], p.reals[0]});
  });
  const auto engines = load(p.b, p.main);
  EXPECT_EQ(Program::any_nan(Program::facts(*engines)), 1u);
  write(*engines, Program::kX, kStrangeNan);
  ASSERT_EQ(engines->scan(0), "");
  EXPECT_EQ(read(*engines, Program::kA + 4), 0x7fc00000u);
  EXPECT_EQ(read(*engines, Program::kKept), 0x7fc00000u);
}

TEST(LoopRanges, AStrangeNanThatNobodyComputedWithStaysAsItIs) {
  // Added to in some rounds only: after the loop it is what it was, or the sum.
  Program p;
  p.loop(7, [&] {
    p.main.op(Opcode::kLtI32, {p.more, p.i, p.n});
    const std::uint32_t past = p.main.jump(Opcode::kCondJump, {p.more});
    p.add(p.reals[0], p.reals[1]);
    p.main.land(past);
  });
  const auto engines = load(p.b, p.main);
  EXPECT_EQ(Program::any_nan(Program::facts(*engines)), 0u);
  for (const std::uint32_t n : {0u, 5u}) {
    write(*engines, Program::kSum, kStrangeNan);
    write(*engines, Program::kN, n);
    ASSERT_EQ(engines->scan(0), "");
    EXPECT_EQ(read(*engines, Program::kSum), n == 0 ? kStrangeNan : 0x7fc00000u);
  }
}

TEST(LoopRanges, TheBudgetEndsARoundOfAnyNumberWithAllPutRight) {
  for (std::uint32_t budget = 1; budget <= 9; ++budget) {
    Program p;
    p.main.op(Opcode::kMoveF32, {p.reals[0], p.b.constant(TypeId::kReal, 0.0f)});
    p.loop(20, [&] { p.add(p.reals[0], p.reals[1]); });
    const auto engines = load(p.b, p.main, budget);
    EXPECT_EQ(Program::facts(*engines).unread.size(), 1u);
    write(*engines, Program::kX, kStrangeNan);
    ASSERT_EQ(engines->scan(0), "") << budget;
    EXPECT_EQ(engines->fault().kind, runtime::FaultKind::kLoopBudget);
    EXPECT_EQ(read(*engines, Program::kSum), 0x7fc00000u);
  }
}

TEST(LoopRanges, AResultThatSomebodyReadsIsStored) {
  Program p;
  const Word seen = p.main.variable("seen", p.b.boolean());
  p.loop(7, [&] { p.main.op(Opcode::kMoveBool, {seen, p.more}); });
  const auto engines = load(p.b, p.main);
  EXPECT_TRUE(Program::facts(*engines).unread.empty());
  for (int scan = 0; scan < 2; ++scan) ASSERT_EQ(engines->scan(scan * kPeriodNs), "");
}

/// Loops in loops made from a seed: indices in and out of their arrays, reals that are computed, moved, stored and
/// compared, ways past and out of all that. Integers are DINT, or INT in one program of four.
class RandomLoops {
 public:
  explicit RandomLoops(std::uint64_t seed) : random_(seed), narrow_(seed % 4 == 0) {
    for (int k = 0; k < 3; ++k) {
      counters_.push_back(main.variable("i" + std::to_string(k), integer_));
      sums_.push_back(main.variable("n" + std::to_string(k), integer_));
    }
    for (int k = 0; k < 4; ++k) reals_.push_back(main.variable("r" + std::to_string(k), real_));
    for (int k = 0; k < 3; ++k) reals_.push_back(main.frame("t" + std::to_string(k), real_));
    words_ = (3 + 3) / (narrow_ ? 2 : 1) + 4 + 10 + 36 + 15;
    list_ = main.variable("list", list_type_);
    square_ = main.variable("square", square_type_);
    points_ = main.variable("points", points_type_);
    seen_ = main.variable("seen", real_);
    index_ = main.frame("index", integer_);
    more_ = main.frame("more", b.boolean());
    const int loops = between(1, 3);
    for (int k = 0; k < loops; ++k) loop(0, one_in(4));
  }
  [[nodiscard]] std::size_t words() const { return words_; }

  ImageBuilder b;
  PouBuilder main = b.pou("Main", PouKind::kProgram);

 private:
  int between(int least, int most) { return std::uniform_int_distribution<int>(least, most)(random_); }
  bool one_in(int n) { return between(1, n) == 1; }
  Word of(const std::vector<Word>& some) {
    return some[static_cast<std::size_t>(between(0, static_cast<int>(some.size()) - 1))];
  }
  Word number(std::int16_t value) {
    return narrow_ ? b.constant(TypeId::kInt, value) : b.constant(TypeId::kDint, std::int32_t{value});
  }
  Word number_between(int least, int most) { return number(static_cast<std::int16_t>(between(least, most))); }
  [[nodiscard]] Opcode of_width(Opcode narrow, Opcode wide) const { return narrow_ ? narrow : wide; }
  Opcode add_or_subtract() {
    return one_in(2) ? of_width(Opcode::kAdd16, Opcode::kAdd32) : of_width(Opcode::kSub16, Opcode::kSub32);
  }
  Word integer() { return one_in(3) ? number_between(-2, 12) : of(one_in(2) ? counters_ : sums_); }
  Word index() {
    if (one_in(3)) return of(counters_);
    main.op(add_or_subtract(), {index_, of(counters_), integer()});
    return index_;
  }
  void compare() {
    static constexpr Opcode kIntegers[] = {Opcode::kLtI32, Opcode::kLeI32, Opcode::kGtI32,
                                           Opcode::kGeI32, Opcode::kEq32,  Opcode::kNe32};
    static constexpr Opcode kNarrow[] = {Opcode::kLtI16, Opcode::kLeI16, Opcode::kGtI16,
                                         Opcode::kGeI16, Opcode::kEq16,  Opcode::kNe16};
    static constexpr Opcode kReals[] = {Opcode::kLtF32, Opcode::kGeF32, Opcode::kEqF32, Opcode::kNeF32};
    if (one_in(3)) {
      main.op(kReals[between(0, 3)], {more_, of(reals_), of(reals_)});
    } else {
      main.op((narrow_ ? kNarrow : kIntegers)[between(0, 5)], {more_, of(one_in(2) ? counters_ : sums_), integer()});
    }
  }
  /// `straight`: nothing but arithmetic and elements, most of which are inside.
  void loop(std::size_t depth, bool straight = false) {
    const Word i = counters_[depth];
    const Word first = one_in(straight ? 20 : 6) ? of(sums_) : straight ? number_between(0, 2) : number_between(-1, 2);
    main.op(of_width(Opcode::kMove16, Opcode::kMove32), {i, first});
    const std::uint32_t head = main.here();
    exits_.emplace_back();
    const int statements = between(1, straight ? 4 : 5);
    for (int k = 0; k < statements; ++k) straight ? straight_statement() : statement(depth);
    const Word last = one_in(straight ? 20 : 5) ? of(sums_) : straight ? number_between(3, 5) : number_between(3, 10);
    main.op(of_width(Opcode::kLtI16, Opcode::kLtI32), {more_, i, last});
    const std::uint32_t out = main.jump(Opcode::kCondJump, {more_});
    main.op(of_width(Opcode::kAdd16, Opcode::kAdd32), {i, i, number_between(1, straight && one_in(2) ? 1 : 3)});
    main.op(Opcode::kLoopJump, {head});
    main.land(out);
    for (const std::uint32_t exit : exits_.back()) main.land(exit);
    exits_.pop_back();
  }
  void straight_statement() {
    static constexpr Opcode kArithmetic[] = {Opcode::kAddF32, Opcode::kSubF32, Opcode::kMulF32, Opcode::kDivF32};
    using bytecode::PathStep;
    switch (between(0, 9)) {
      case 0:
      case 1:
        main.op(kArithmetic[between(0, 3)], {of(reals_), of(reals_), of(reals_)});
        break;
      case 2:
        if (one_in(2)) {
          main.op(of_width(Opcode::kMove16, Opcode::kMove32), {of(counters_), number_between(0, 4)});
        } else {
          main.op(add_or_subtract(), {of(one_in(3) ? counters_ : sums_), of(counters_), integer()});
        }
        break;
      case 3:
        part(list_, list_type_, {{PathStep::kIndex, index()}});
        break;
      case 4:
      case 5:
        part(points_, points_type_,
             {{PathStep::kIndex, of(counters_)}, {PathStep::kElement, static_cast<std::uint32_t>(between(0, 2))}});
        break;
      default:
        part(square_, square_type_,
             {{PathStep::kIndex, of(counters_)}, {PathStep::kIndex, one_in(4) ? index() : of(counters_)}});
    }
  }
  void part(Word array, std::uint32_t type, const std::vector<PouBuilder::Step>& steps) {
    if (one_in(2)) {
      main.path(Opcode::kLoadAt, {of(reals_), array, type}, steps);
    } else {
      main.path(Opcode::kStoreAt, {array, of(reals_), type}, steps);
    }
  }
  void statement(std::size_t depth) {
    static constexpr Opcode kArithmetic[] = {Opcode::kAddF32, Opcode::kSubF32, Opcode::kMulF32, Opcode::kDivF32};
    using bytecode::PathStep;
    switch (between(0, 14)) {
      case 0:
      case 1:
      case 2:
        main.op(kArithmetic[between(0, 3)], {of(reals_), of(reals_), of(reals_)});
        break;
      case 3:
        main.path(Opcode::kLoadAt, {of(reals_), list_, list_type_}, {{PathStep::kIndex, index()}});
        break;
      case 4:
        main.path(Opcode::kStoreAt, {list_, of(reals_), list_type_}, {{PathStep::kIndex, index()}});
        break;
      case 5:
        part(square_, square_type_, {{PathStep::kIndex, of(counters_)}, {PathStep::kIndex, index()}});
        break;
      case 14: {
        const std::uint32_t coordinate = static_cast<std::uint32_t>(between(0, 2));
        part(points_, points_type_, {{PathStep::kIndex, of(counters_)}, {PathStep::kElement, coordinate}});
        break;
      }
      case 6:
        main.op(Opcode::kMoveF32, {of(reals_), one_in(2) ? of(reals_) : b.constant(TypeId::kReal, 0.5f)});
        break;
      case 7:
        main.op(Opcode::kMoveF32, {seen_, of(reals_)});
        break;
      case 8:
        main.op(add_or_subtract(), {of(sums_), of(sums_), integer()});
        break;
      case 9:
        if (one_in(6)) {
          main.op(of_width(Opcode::kAdd16, Opcode::kAdd32), {of(counters_), of(counters_), number_between(1, 2)});
        }
        break;
      case 10: {
        compare();
        const std::uint32_t past = main.jump(one_in(2) ? Opcode::kCondJump : Opcode::kJumpIf, {more_});
        statement(depth);
        const bool other = one_in(2);
        const std::uint32_t end = other ? main.jump(Opcode::kJump) : 0;
        main.land(past);
        if (other) {
          statement(depth);
          main.land(end);
        }
        break;
      }
      case 11:
        compare();
        exits_.back().push_back(main.jump(Opcode::kCondJump, {more_}));
        break;
      case 12:
        if (one_in(2)) {
          main.call_std("SQRT:REAL", of(reals_), {of(reals_)});
        } else {
          main.call_std(narrow_ ? "REAL_TO_INT:REAL,INT" : "REAL_TO_DINT:REAL,DINT", of(sums_), {of(reals_)});
        }
        break;
      default:
        if (depth < 2) loop(depth + 1, one_in(2));
        break;
    }
  }

  std::mt19937_64 random_;
  std::uint32_t real_ = b.type(TypeId::kReal);
  bool narrow_;
  std::uint32_t integer_ = b.type(narrow_ ? TypeId::kInt : TypeId::kDint);
  std::uint32_t list_type_ = b.array(real_, 10, -1);
  std::uint32_t row_type_ = b.array(real_, 6);
  std::uint32_t square_type_ = b.array(row_type_, 6);
  std::uint32_t points_type_ = b.array(b.array(real_, 3), 5);
  std::vector<Word> counters_, sums_, reals_;
  Word list_ = 0, square_ = 0, points_ = 0, seen_ = 0, index_ = 0, more_ = 0;
  std::size_t words_ = 0;
  std::vector<std::vector<std::uint32_t>> exits_;  ///< jumps out of each loop
};

TEST(LoopRanges, RandomLoopsLeaveTheSameTables) {
  static constexpr std::uint32_t kWords[] = {0,           1,           3,           0xffffffffu, 0x3f800000u,
                                             0x7f800000u, 0x7fc00000u, kStrangeNan, 0x7f800001u, 0xc0490fdbu};
  for (std::uint64_t seed = 1; seed <= 2000; ++seed) {
    RandomLoops loops(seed);
    std::mt19937_64 random(seed);
    const auto engines = load(loops.b, loops.main, static_cast<std::uint32_t>(20 + random() % 2000));
    ASSERT_NE(engines, nullptr);
    for (int scan = 0; scan < 4; ++scan) {
      for (std::size_t word = 0; word < loops.words(); ++word) {
        if (random() % 3 == 0) write(*engines, word * 4, kWords[random() % std::size(kWords)]);
      }
      ASSERT_EQ(engines->scan(scan * kPeriodNs), "") << "seed " << seed;
    }
  }
}

}  // namespace
}  // namespace plc::test
