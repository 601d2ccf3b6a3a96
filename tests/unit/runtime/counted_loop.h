// A counted loop as FOR makes it, around any body: run with what the interpreter makes of it, and as it is written.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tests/unit/runtime/run_support.h"

namespace plc::test {

using bytecode::Opcode;
using core::TypeId;

/// FOR i := first TO last BY step: arrays x (DINT), y (DINT), r (REAL), all [0..99]; x and r hold numbers.
class CountedLoop {
 public:
  using Body = std::function<void(CountedLoop&)>;
  /// What it counts from, to and by.
  enum class Rounds : std::uint8_t { kConstant, kVariable };
  CountedLoop(std::int32_t first, std::int32_t last, const Body& body, std::int32_t step = 1,
              Rounds rounds = Rounds::kConstant) {
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
    more = main.frame("more", b.boolean());
    const bool vary = rounds == Rounds::kVariable;
    const Word limit = vary ? variable("last", last) : number(last);
    const Word by = vary ? variable("by", std::abs(step)) : number(std::abs(step));
    main.op(Opcode::kMove32, {i, vary ? variable("first", first) : number(first)});
    const std::uint32_t head = main.here();
    body(*this);
    main.op(step > 0 ? Opcode::kLtI32 : Opcode::kGtI32, {more, i, limit});
    const std::uint32_t out = main.jump(Opcode::kCondJump, {more});
    main.op(step > 0 ? Opcode::kAdd32 : Opcode::kSub32, {i, i, by});
    main.op(Opcode::kLoopJump, {head});
    main.land(out);
    main.op(Opcode::kAdd32, {main.variable("behind", dint), i, number(1)});
    b.task("Cyclic", 10'000'000, {main.finish()});
  }

  /// Runs three scans with and without what the interpreter makes of loops: the same bytes, faults and events. Returns
  /// what it made.
  runtime::Program::LinkReport report(std::uint32_t budget = 10'000) {
    runtime::ProgramOptions options;
    options.loop_budget = budget;
    arranged = load(b, options);
    options.arrange = false;
    plain = load(b, options);
    if (arranged == nullptr || plain == nullptr) return {};
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
    EXPECT_EQ(plain->program(0).link_report().choices, 0u);
    return arranged->program(0).link_report();
  }
  /// Returns how many loops were runs.
  std::uint64_t run(std::uint32_t budget = 10'000) { return report(budget).loops; }

  Word variable(const char* name, std::int32_t value) {
    std::vector<std::byte> bytes(sizeof value);
    std::memcpy(bytes.data(), &value, sizeof value);
    return main.variable(name, dint, bytecode::FieldRole::kLocal, bytes);
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
  Word more = 0;  ///< whether the loop goes on; the compiler lets IFs of the body use it too
  std::unique_ptr<runtime::Resource> arranged, plain;
  runtime::Fault fault;

 private:
  int made_ = 0;
};

}  // namespace plc::test
