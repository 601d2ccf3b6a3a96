// Boolean runs as code: what stays in registers, and where it is when a block takes it from there.
#include "native/records.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "native/compile.h"
#include "stdlib/library.h"
#include "tests/support/engines.h"
#include "tests/support/image_builder.h"
#include "tests/unit/native/loop_support.h"

namespace plc::test {
namespace {

using native::kNever;
using native::Record;

Record reads(std::uint32_t out, std::initializer_list<std::pair<std::uint32_t, std::uint32_t>> inputs) {
  Record record;
  record.out = out;
  for (const auto& [operand, next] : inputs) {
    record.in[record.inputs] = operand;
    record.next[record.inputs++] = next;
  }
  return record;
}

TEST(Records, AnInputThatWouldGiveUpItsRegisterIsReadFromMemory) {
  enum : std::uint32_t { kA, kB, kC, kOut };
  std::vector<Record> records = {reads(kOut, {{kA, 3}}), reads(kOut + 1, {{kB, 2}, {kC, 2}}),
                                 reads(kOut + 2, {{kB, 3}, {kC, kNever}}),
                                 reads(kOut + 3, {{kA, kNever}, {kB, kNever}})};
  std::vector<Record> enough = records;
  native::forget_late_readers(enough, 3);
  EXPECT_EQ(enough[0].next[0], 3u);
  native::forget_late_readers(records, 2);
  EXPECT_EQ(records[0].next[0], kNever) << "B and C come first";
  EXPECT_EQ(records[1].next[0], 2u);
  EXPECT_EQ(records[1].next[1], 2u);
  EXPECT_EQ(records[2].next[0], 3u) << "C is not needed any more";
}

TEST(Records, WhatIsInARegisterAloneIsNotForgotten) {
  enum : std::uint32_t { kTemporary, kOut };
  std::vector<Record> records = {reads(kTemporary, {}), reads(kOut, {{kTemporary, 2}}),
                                 reads(kOut + 1, {{kTemporary, kNever}}), reads(kTemporary, {})};
  records[0].is_overwritten = true;  // by the last one: nobody has stored it
  records[0].next_of_out = 1;
  native::forget_late_readers(records, 0);
  EXPECT_EQ(records[0].next_of_out, 1u);
  EXPECT_EQ(records[1].next[0], 2u);

  records[0].is_overwritten = false;
  native::forget_late_readers(records, 0);
  EXPECT_EQ(records[1].next[0], kNever) << "it is in the table";
}

/// Blocks after boolean logic that leaves their inputs in any registers, beside values that it holds.
TEST(Records, BlocksFindTheirInputsInAnyRegister) {
  struct Kind {
    const char* name;
    std::vector<const char*> inputs;  ///< BOOL
  };
  const std::vector<Kind> kinds = {{"CTU", {"CU", "R"}},
                                   {"CTD", {"CD", "LD"}},
                                   {"CTU_DINT", {"CU", "R"}},
                                   {"CTD_LINT", {"CD", "LD"}},
                                   {"TON", {"IN"}},
                                   {"TOF", {"IN"}},
                                   {"TP", {"IN"}},
                                   {"R_TRIG", {"CLK"}},
                                   {"F_TRIG", {"CLK"}}};
  constexpr std::uint32_t kPrograms = 60, kBlocks = 30;
  for (std::uint32_t seed = 0; seed < kPrograms; ++seed) {
    std::mt19937 random(seed);
    const auto below = [&random](std::size_t end) { return static_cast<std::uint32_t>(random() % end); };
    ImageBuilder b;
    PouBuilder main = b.pou("Main", PouKind::kProgram);
    const Word count = main.variable("count", b.type(TypeId::kByte));
    std::vector<Word> bits;
    for (Word bit = 0; bit < 8; ++bit) {
      bits.push_back(main.variable("in" + std::to_string(bit), b.boolean()));
      main.op(Opcode::kExtract, {bits.back(), count, bit});
    }
    main.op(Opcode::kAdd8, {count, count, b.constant<std::uint8_t>(TypeId::kByte, 29)});
    for (Word n = 0; n < 6; ++n) bits.push_back(main.variable("out" + std::to_string(n), b.boolean()));
    for (std::uint32_t n = 0; n < kBlocks; ++n) {
      const Kind& kind = kinds[below(kinds.size())];
      const stdlib::BlockSpec* const spec = stdlib::block_named(kind.name);
      ASSERT_NE(spec, nullptr) << kind.name;
      const Word instance = main.variable("block" + std::to_string(n), b.block_type(kind.name));
      std::vector<Word> words;
      std::uint32_t records = 0;
      const auto add = [&](Word out) {
        words.insert(words.end(), {static_cast<Word>(random()), out});
        for (int k = 0; k < 5; ++k) words.push_back(bits[below(bits.size())]);
        ++records;
      };
      for (std::uint32_t more = 4 + below(12); more != 0; --more) add(bits[8 + below(6)]);
      const std::size_t first = below(2);
      for (std::size_t k = 0; k < kind.inputs.size(); ++k) {
        const char* const port = kind.inputs[(k + first) % kind.inputs.size()];
        add(instance + stdlib::field_named(*spec, port)->offset);
      }
      main.list(Opcode::kBoolRun, records, std::move(words));
      main.op(Opcode::kRunTb, {b.block(kind.name), instance});
    }
    const auto engines = load(b, main);
    ASSERT_NE(engines, nullptr);
    for (std::int64_t scan = 0; scan < 40; ++scan) {
      ASSERT_EQ(engines->scan(scan * kPeriodNs), "") << "seed " << seed << ", scan " << scan;
    }
  }
}

}  // namespace
}  // namespace plc::test
