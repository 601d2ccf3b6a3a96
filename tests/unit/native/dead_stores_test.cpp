// Results that nobody stores: only those that nobody could look for.
#include "native/dead_stores.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string_view>

#include "stdlib/library.h"
#include "tests/support/engines.h"
#include "tests/support/image_builder.h"
#include "tests/unit/native/loop_support.h"

namespace plc::test {
namespace {

/// Four DINT, four REAL and two BOOL of the instance, temporaries of each type.
struct Program {
  Program() {
    for (const char* name : {"a", "b", "c", "d"}) ints.push_back(main.variable(name, dint));
    for (const char* name : {"p", "q", "r", "s"}) reals.push_back(main.variable(name, real));
    for (const char* name : {"x", "y"}) bits.push_back(main.variable(name, b.boolean()));
    for (const char* name : {"t0", "t1"}) t.push_back(main.frame(name, dint));
    for (const char* name : {"f0", "f1"}) f.push_back(main.frame(name, real));
  }

  Word number(std::int32_t value) { return b.constant(TypeId::kDint, value); }
  Word number(float value) { return b.constant(TypeId::kReal, value); }
  /// Writes all temporaries, so that nothing before it is worth keeping.
  void overwrite() {
    for (const Word word : t) main.op(Opcode::kAdd32, {word, ints[3], ints[3]});
    for (const Word word : f) main.op(Opcode::kAddF32, {word, reals[3], reals[3]});
  }
  /// How many results of the task are not stored; scans with several inputs, of which all engines make the same.
  std::size_t left_out() {
    const auto engines = load(b, main);
    if (engines == nullptr) return ~std::size_t{0};
    for (std::uint32_t scan = 0; scan < kScans; ++scan) {
      for (std::size_t e = 0; e < engines->size(); ++e) write_inputs((*engines)[e].program(0), scan);
      EXPECT_EQ(engines->scan(scan * kPeriodNs), "") << "scan " << scan;
    }
    const runtime::LinkedCode& linked = (*engines)[0].program(0).linked();
    std::size_t count = 0;
    for (std::size_t n = 0; n < linked.bodies.size(); ++n) {
      const auto body = linked.instructions_of(n);
      for (const auto& operand : native::find_dead_stores(linked, body)) count += operand ? 1 : 0;
    }
    return count;
  }

  static constexpr std::uint32_t kScans = 24;
  /// Numbers of all kinds: small and great ones, zeros, NaN, infinity.
  static void write_inputs(runtime::Program& program, std::uint32_t scan) {
    static constexpr std::int32_t kInts[] = {3, -7, 0, 2147483647, -2147483647 - 1};
    static constexpr std::uint32_t kReals[] = {0x40490fdbu, 0xc2f6e979u, 0x7f800000u, 0x80000000u, 0x7fc00000u, 0u};
    std::byte* const instance = program.table().data() + program.table().layout().instance;
    for (std::uint32_t n = 0; n < 4; ++n) {
      std::memcpy(instance + n * 4, &kInts[(scan + n * 2) % std::size(kInts)], 4);
      std::memcpy(instance + 16 + n * 4, &kReals[(scan / 2 + n * (1 + scan % 2)) % std::size(kReals)], 4);
    }
    instance[32] = static_cast<std::byte>(scan & 1u);
  }

  ImageBuilder b;
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  std::uint32_t dint = b.type(TypeId::kDint);
  std::uint32_t real = b.type(TypeId::kReal);
  std::vector<Word> ints, reals, bits, t, f;
};

TEST(DeadStores, AChainOfIntegersStoresWhatSomebodyReadsLater) {
  Program p;
  p.main.op(Opcode::kAdd32, {p.t[0], p.ints[0], p.number(85)});
  p.main.call_std("LIMIT:DINT", p.t[1], {p.number(-50), p.t[0], p.number(900)});
  p.main.op(Opcode::kMul32, {p.t[0], p.t[1], p.ints[1]});
  p.main.call_std("MIN:DINT", p.ints[2], {p.t[0], p.ints[1]});
  p.overwrite();
  EXPECT_EQ(p.left_out(), 3u);
}

TEST(DeadStores, AChainOfRealsDoesSo) {
  Program p;
  p.main.op(Opcode::kMulF32, {p.f[0], p.reals[0], p.reals[1]});
  p.main.op(Opcode::kSubF32, {p.f[1], p.reals[2], p.f[0]});
  p.main.call_std("MAX:REAL", p.f[0], {p.f[1], p.reals[1]});
  p.main.call_std("SEL:REAL", p.f[1], {p.bits[0], p.f[0], p.reals[0]});
  p.main.call_std("SEL:REAL", p.f[0], {p.bits[0], p.reals[0], p.f[1]});
  p.main.op(Opcode::kMoveF32, {p.reals[2], p.f[0]});
  p.overwrite();
  EXPECT_EQ(p.left_out(), 5u);
}

TEST(DeadStores, EveryOperationTakesWhatTheOneInFrontLeft) {
  for (const auto op : {Opcode::kAdd32, Opcode::kSub32, Opcode::kMul32, Opcode::kDivI32, Opcode::kModI32,
                        Opcode::kAnd32, Opcode::kXor32, Opcode::kLtI32}) {
    for (const auto from : {Opcode::kAdd32, Opcode::kModI32, Opcode::kDivI32}) {
      for (const bool second : {false, true}) {
        Program p;
        const Word to = op == Opcode::kLtI32 ? p.bits[1] : p.ints[2];
        p.main.op(from, {p.t[0], p.ints[0], p.ints[1]});
        p.main.op(op, {to, second ? p.ints[3] : p.t[0], second ? p.t[0] : p.ints[3]});
        p.overwrite();
        EXPECT_EQ(p.left_out(), 1u) << static_cast<int>(op) << ' ' << static_cast<int>(from) << ' ' << second;
      }
    }
  }
}

TEST(DeadStores, ItMayBeWrittenAgainByWhoReadsIt) {
  Program p;
  p.main.op(Opcode::kAdd32, {p.t[0], p.ints[0], p.ints[1]});
  p.main.op(Opcode::kSub32, {p.t[0], p.ints[2], p.t[0]});
  p.main.op(Opcode::kMove32, {p.ints[3], p.t[0]});
  EXPECT_EQ(p.left_out(), 1u);  // the last one stays in the table
}

TEST(DeadStores, WhatIsReadTwiceIsStored) {
  Program p;
  p.main.op(Opcode::kAdd32, {p.t[0], p.ints[0], p.ints[1]});
  p.main.op(Opcode::kMul32, {p.t[1], p.t[0], p.t[0]});
  p.main.op(Opcode::kMove32, {p.ints[2], p.t[1]});
  p.main.op(Opcode::kMove32, {p.ints[1], p.t[1]});
  p.overwrite();
  EXPECT_EQ(p.left_out(), 0u);
}

TEST(DeadStores, WhatIsReadLaterIsStored) {
  Program p;
  p.main.op(Opcode::kAdd32, {p.t[0], p.ints[0], p.ints[1]});
  p.main.op(Opcode::kAdd32, {p.t[1], p.ints[0], p.ints[2]});
  p.main.op(Opcode::kSub32, {p.ints[2], p.t[0], p.ints[3]});
  p.main.op(Opcode::kSub32, {p.ints[1], p.t[1], p.ints[3]});
  p.overwrite();
  EXPECT_EQ(p.left_out(), 0u);
}

TEST(DeadStores, WhatACallLooksAtIsStored) {
  Program p;
  p.main.op(Opcode::kMulF32, {p.f[0], p.reals[0], p.reals[1]});
  p.main.call_std("SQRT:REAL", p.reals[2], {p.f[0]});  // its rare cases are a call
  p.main.op(Opcode::kAdd32, {p.t[0], p.ints[0], p.ints[1]});
  p.main.call_std("LIMIT:DINT", p.ints[2], {p.t[0], p.ints[0], p.ints[3]});  // where the code loads a bound
  p.overwrite();
  EXPECT_EQ(p.left_out(), 0u);
}

TEST(DeadStores, WhatIsThereWhenSomebodyJumpsIsStored) {
  Program p;
  p.main.op(Opcode::kAdd32, {p.t[0], p.ints[0], p.ints[1]});
  p.main.op(Opcode::kSub32, {p.ints[2], p.t[0], p.ints[3]});
  const std::uint32_t over = p.main.jump(Opcode::kCondJump, {p.bits[0]});
  p.overwrite();
  p.main.land(over);
  p.main.op(Opcode::kMove32, {p.ints[1], p.t[0]});
  EXPECT_EQ(p.left_out(), 0u);
}

TEST(DeadStores, WhoIsJumpedToTakesItFromTheTable) {
  Program p;
  p.main.op(Opcode::kSub32, {p.t[0], p.ints[0], p.ints[1]});
  const std::uint32_t over = p.main.jump(Opcode::kCondJump, {p.bits[0]});
  p.main.op(Opcode::kAdd32, {p.t[0], p.ints[0], p.ints[1]});
  p.main.land(over);
  p.main.op(Opcode::kMove32, {p.ints[2], p.t[0]});
  p.overwrite();
  EXPECT_EQ(p.left_out(), 0u);
}

TEST(DeadStores, WhatIsThereWhenAScanEndsInALoopIsStored) {
  Program p;
  p.main.op(Opcode::kAdd32, {p.t[0], p.ints[0], p.ints[1]});
  p.main.op(Opcode::kSub32, {p.ints[2], p.t[0], p.ints[3]});
  const std::uint32_t head = p.main.here();
  p.main.op(Opcode::kAdd32, {p.ints[3], p.ints[3], p.number(1)});
  p.main.op(Opcode::kLoopJump, {head});
  EXPECT_EQ(p.left_out(), 0u);
}

TEST(DeadStores, BooleanLogicInBetweenReadsWhatItReads) {
  for (const bool reads : {false, true}) {
    Program p;
    p.main.op(Opcode::kLtI32, {p.bits[1], p.ints[0], p.ints[1]});
    p.main.call_std("NOT:BOOL", p.bits[1], {p.bits[1]});
    p.main.record(0b01, p.bits[0], {reads ? p.bits[1] : p.bits[0]});
    p.main.op(Opcode::kLtI32, {p.bits[1], p.ints[2], p.ints[3]});
    // The comparison is overwritten at once; the NOT only if nobody looks, and nobody takes it from a register.
    EXPECT_EQ(p.left_out(), 1u) << reads;
  }
}

}  // namespace
}  // namespace plc::test
