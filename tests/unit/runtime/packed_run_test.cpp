// Packed stretches against a plain model: windows, bytes outside of them, instances, other instructions in between.
#include "runtime/packed_run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <random>
#include <set>

#include "runtime/link_packed.h"
#include "runtime/packed_columns.h"

namespace plc::test {
namespace {

using runtime::PackedStretch;
using runtime::StretchItem;

constexpr std::uint32_t kTableBytes = 4096, kScratch = 3000, kInstance = 2000;

std::uint32_t place_of(std::uint32_t operand) {
  return (operand & ~runtime::kRelativeBit) + ((operand & runtime::kRelativeBit) != 0 ? kInstance : 0);
}

/// Logic on bytes at `places`, with other instructions in it.
struct Logic {
  std::vector<std::uint32_t> places;  ///< operands, ascending
  std::vector<StretchItem> items;

  void record(std::uint32_t truth, std::vector<std::uint32_t> in, std::uint32_t out) {
    items.push_back({true, 0, truth, std::move(in), {out}});
  }

  /// `others`: one instruction in so many is not a record.
  static Logic random(std::mt19937& random, std::vector<std::uint32_t> places, std::size_t count, std::size_t others) {
    Logic logic;
    std::sort(places.begin(), places.end());
    logic.places = std::move(places);
    const auto some = [&](std::size_t n) {
      std::vector<std::uint32_t> cells;
      for (; n > 0; --n) cells.push_back(static_cast<std::uint32_t>(random() % logic.places.size()));
      return cells;
    };
    // Some hold values for a short time only.
    const std::vector<std::uint32_t> temporaries = some(4);
    for (std::size_t i = 0; i < count; ++i) {
      if (random() % others == 0) {
        StretchItem other;
        other.kind = static_cast<std::uint32_t>(random() % 3);
        other.reads = some(random() % 4);
        other.writes = some(random() % 3);
        if (other.writes.size() == 2 && other.writes[0] == other.writes[1]) other.writes.pop_back();
        logic.items.push_back(other);
        continue;
      }
      constexpr std::size_t kInputs[] = {1, 2, 4, 5};
      auto in = some(kInputs[random() % 4]);
      if (random() % 2 == 0) in[0] = temporaries[random() % 4];
      const auto out = random() % 2 == 0 ? temporaries[random() % 4] : some(1)[0];
      logic.record(static_cast<std::uint32_t>(random()), std::move(in), out);
    }
    return logic;
  }

  [[nodiscard]] std::uint8_t& at(std::vector<std::uint8_t>& bytes, std::uint32_t cell) const {
    return bytes[place_of(places[cell])];
  }
  void run_item(std::vector<std::uint8_t>& bytes, const StretchItem& item) const {
    if (item.logic) {
      std::uint32_t index = 0;
      for (std::size_t k = 0; k < item.reads.size(); ++k) {
        index |= static_cast<std::uint32_t>(at(bytes, item.reads[k])) << k;
      }
      at(bytes, item.writes[0]) = static_cast<std::uint8_t>((item.truth >> index) & 1u);
      return;
    }
    std::uint32_t sum = item.kind;
    for (const std::uint32_t cell : item.reads) sum = sum * 3 + at(bytes, cell);
    for (const std::uint32_t cell : item.writes) at(bytes, cell) = static_cast<std::uint8_t>((sum++ >> 1) & 1u);
  }

  void run_packed(std::vector<std::uint8_t>& bytes, const PackedStretch& packed) const {
    const runtime::ValueRun run = runtime::packed_run(packed.form);
    for (const runtime::PackedStep& step : packed.steps) {
      for (const std::uint32_t item : step.items) run_item(bytes, items[item]);
      if (!step.items.empty()) continue;
      const std::uint32_t* const end =
          run(reinterpret_cast<std::byte*>(bytes.data()), kInstance, step.words.data(), step.chunks);
      EXPECT_EQ(end, step.words.data() + step.words.size());
    }
  }

  /// Runs both on random bytes. Places hold BOOLs, everything else any bytes, which nobody may change.
  void expect_as_model(std::mt19937& random, const PackedStretch& packed) const {
    std::vector<std::uint8_t> bytes(kTableBytes);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
    for (const std::uint32_t place : places) bytes[place_of(place)] &= 1u;
    std::vector<std::uint8_t> model = bytes;
    for (const StretchItem& item : items) run_item(model, item);
    run_packed(bytes, packed);
    for (std::uint32_t i = 0; i < kTableBytes; ++i) {
      if (i >= kScratch && i < kScratch + runtime::kPackedStateBytes) continue;
      ASSERT_EQ(bytes[i], model[i]) << i;
    }
  }
};

std::vector<std::uint32_t> row(std::uint32_t first, std::uint32_t count, std::uint32_t step = 1) {
  std::vector<std::uint32_t> operands;
  for (std::uint32_t i = 0; i < count; ++i) operands.push_back(first + step * i);
  return operands;
}
std::vector<std::uint32_t> joined(std::vector<std::uint32_t> a, const std::vector<std::uint32_t>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

class PackedRun : public testing::Test {
 protected:
  void SetUp() override {
    if (runtime::packed_run({}) == nullptr) GTEST_SKIP() << "this processor has no fast PEXT";
  }
  static std::optional<PackedStretch> pack(const Logic& logic) {
    return runtime::pack(logic.items, logic.places, kScratch);
  }
};

TEST_F(PackedRun, RunsAsTheModel) {
  const std::vector<std::uint32_t> kPlaces[] = {
      row(100, 8),
      row(101, 60),
      row(77, 110),
      row(70, 125),
      row(10, 40, 3),                                        // outside of windows, mostly
      joined(row(100, 30), row(1000, 30)),                   // two windows
      joined(row(100, 20), row(runtime::kRelativeBit, 30)),  // of an instance
      joined(row(100, 62), row(500, 20, 70)),
  };
  std::mt19937 random(3);
  std::size_t packed_in[3] = {}, delayed_by[4] = {}, runs = 0;
  for (const auto& places : kPlaces) {
    for (int n = 0; n < 300; ++n) {
      const Logic logic = Logic::random(random, places, 1 + random() % 120, n % 3 == 0 ? 1000 : 2 + random() % 20);
      const auto packed = pack(logic);
      if (!packed) continue;
      ++packed_in[packed->form.words];
      ++delayed_by[packed->form.delay];
      runs += packed->steps.size();
      for (int scan = 0; scan < 3; ++scan) logic.expect_as_model(random, *packed);
      if (HasFailure()) return;
    }
  }
  EXPECT_GT(packed_in[1], 500u);
  EXPECT_GT(packed_in[2], 300u);
  EXPECT_GT(delayed_by[2], 300u);
  EXPECT_GT(delayed_by[3], 300u);
  EXPECT_GT(runs, 3 * (packed_in[1] + packed_in[2])) << "most should have other instructions between runs";
}

TEST_F(PackedRun, TooManyVariablesAreNotPacked) {
  Logic logic;
  logic.places = row(0, 130);
  for (std::uint32_t i = 0; i < 65; ++i) logic.record(0x6, {2 * i, (2 * i + 1) % 130}, 2 * i + 1);
  EXPECT_FALSE(pack(logic));
  logic.items.pop_back();
  EXPECT_TRUE(pack(logic));
}

TEST_F(PackedRun, PaysForManyIndependentRecordsOnFewVariables) {
  Logic many, chain, far;
  many.places = chain.places = row(0, 64);
  far.places = joined(row(0, 16), row(200, 48, 100));
  for (std::uint32_t i = 0; i < 48; ++i) {
    std::vector<std::uint32_t> in, far_in;
    for (std::uint32_t k = 0; k < 4; ++k) {
      in.push_back(48 + (i + k) % 16);
      far_in.push_back((i + k) % 16);
    }
    many.record(0x8000, in, i);
    far.record(0x8000, far_in, 16 + i);
    chain.record(0x8000, {i == 0 ? 48 : i - 1, 50 + i % 7, 57, 58}, i);
  }
  EXPECT_TRUE(pack(many)->pays);
  EXPECT_FALSE(pack(chain)->pays) << "each record waits for the one before";
  EXPECT_FALSE(pack(far)->pays) << "no window holds the results";
}

/// Records that are one: what only the next one reads, up to six inputs.
TEST_F(PackedRun, JoinsRecordsOfOneReader) {
  Logic logic;
  logic.places = joined(row(0, 20), {100});
  constexpr std::uint32_t kTemporary = 20;
  const auto chunks = [&] {
    std::size_t count = 0;
    for (const auto& step : pack(logic)->steps) count += step.chunks;
    return count;
  };
  logic.record(0x80000000, {0, 1, 2, 3, 4}, kTemporary);
  logic.record(0xe, {kTemporary, 5}, 5);
  logic.record(0x80000000, {6, 7, 8, 9, 10}, kTemporary);
  logic.record(0xe, {kTemporary, 11}, 11);
  logic.record(0x1, {12, 13}, kTemporary);  // what is left of it behind the stretch
  EXPECT_EQ(chunks(), 1u);
  logic.items[3].reads.push_back(12);  // of seven inputs
  EXPECT_GT(chunks(), 1u);
  std::mt19937 random(5);
  logic.expect_as_model(random, *pack(logic));
}

TEST_F(PackedRun, TwoWindowsHoldWhatTwoWindowsCan) {
  Logic logic;
  logic.places = row(100, 80);
  for (std::uint32_t i = 0; i + 3 < 80; ++i) logic.record(0x8000, {i, i + 1, i + 2, i + 3}, (i * 7) % 80);
  const auto packed = pack(logic);
  ASSERT_EQ(packed->steps.size(), 1u);
  runtime::PackedHeader header;
  std::memcpy(static_cast<void*>(&header), packed->steps[0].words.data(), sizeof header);
  EXPECT_EQ(header.windows, 2u);
  EXPECT_EQ(header.gathers + header.scatters, 0u);
}

/// Records on any four of 100 variables: without an order of their own, some would need both bits of a column.
TEST_F(PackedRun, InputsOfAChunkAreInDifferentColumns) {
  std::mt19937 random(7);
  for (int n = 0; n < 200; ++n) {
    Logic logic;
    logic.places = row(100, 100);
    for (std::uint32_t i = 0; i < 90; ++i) {
      std::vector<std::uint32_t> in;
      for (int k = 0; k < 4; ++k) in.push_back(static_cast<std::uint32_t>(random() % 100));
      logic.record(static_cast<std::uint32_t>(random()) & 0xffffu, in, i);
    }
    const auto packed = pack(logic);
    ASSERT_TRUE(packed);
    EXPECT_EQ(packed->form.words, 2u);
    for (int scan = 0; scan < 3; ++scan) logic.expect_as_model(random, *packed);
    if (HasFailure()) return;
  }
}

TEST(PackedColumns, GivesEachByteABitWhereItMayBe) {
  std::mt19937_64 random(1);
  std::size_t found = 0;
  for (int n = 0; n < 2000; ++n) {
    std::array<std::uint64_t, runtime::kPackedWindowBytes> blocked;
    for (std::uint64_t& bits : blocked) bits = random() & random();
    if (n % 2 == 0) blocked[random() % 64] |= random() | random() | random();
    const auto bits = runtime::order_window(blocked);
    if (!bits) continue;
    ++found;
    std::set<std::uint8_t> taken;
    for (std::uint32_t byte = 0; byte < runtime::kPackedWindowBytes; ++byte) {
      const std::uint8_t bit = (*bits)[byte];
      EXPECT_EQ(blocked[byte] >> bit & 1u, 0u);
      EXPECT_EQ(bit / runtime::kLaneBytes, byte / runtime::kLaneBytes);
      taken.insert(bit);
    }
    ASSERT_EQ(taken.size(), runtime::kPackedWindowBytes);
  }
  EXPECT_GT(found, 1500u);
}

TEST(PackedColumns, MovesBytesThatCanBeElsewhere) {
  // Byte i may be at i and behind it; the first one is placed at 0 before byte 15 needs that.
  std::array<std::uint64_t, runtime::kPackedWindowBytes> blocked{};
  for (std::uint32_t byte = 0; byte < 15; ++byte) blocked[byte] = ~(std::uint64_t{3} << byte);
  blocked[15] = ~std::uint64_t{1};
  const auto bits = runtime::order_window(blocked);
  ASSERT_TRUE(bits);
  for (std::uint32_t byte = 0; byte < 16; ++byte) EXPECT_EQ((*bits)[byte], (byte + 1) % 16);
  blocked[14] = blocked[15];  // two bytes for one bit
  EXPECT_FALSE(runtime::order_window(blocked));
}

class PackedLogic : public testing::Test {
 protected:
  /// Records on the longest way.
  static std::uint32_t depth(const runtime::PackedLogic& logic) {
    std::vector<std::uint32_t> depths(logic.values().size(), 0);
    std::uint32_t most = 0;
    for (const runtime::PackedNode& node : logic.nodes()) {
      if (node.gone) continue;
      std::uint32_t& own = depths[node.out[0]];
      for (const std::uint32_t in : node.in) own = std::max(own, depths[in] + 1);
      most = std::max(most, own);
    }
    return most;
  }
};

TEST_F(PackedLogic, ShortensWaysUpToSixInputs) {
  Logic logic;
  logic.places = row(0, 32);
  for (std::uint32_t i = 0; i < 15; ++i) logic.record(0x6, {i, 16 + i}, i + 1);  // each waits for the one before
  runtime::PackedLogic packed(logic.items, logic.places);
  packed.join_records();
  EXPECT_EQ(depth(packed), 15u) << "all of them are read behind the stretch";
  EXPECT_TRUE(packed.shorten_ways());
  EXPECT_EQ(depth(packed), 3u);
  for (const runtime::PackedNode& node : packed.nodes()) {
    EXPECT_FALSE(node.gone);
    EXPECT_LE(node.in.size(), runtime::kMostPackedInputs);
  }
  EXPECT_FALSE(packed.shorten_ways()) << "there is nothing left to do";
}

TEST_F(PackedLogic, InputsThatCancelOutAreNotRead) {
  Logic logic;
  logic.places = row(0, 8);
  logic.record(0x8, {0, 1}, 2);  // x AND y
  logic.record(0x2, {0, 1}, 3);  // x AND NOT y
  logic.record(0xe, {2, 3}, 4);  // x
  runtime::PackedLogic packed(logic.items, logic.places);
  EXPECT_TRUE(packed.shorten_ways());
  EXPECT_EQ(packed.nodes()[2].in, (std::vector<std::uint32_t>{packed.nodes()[0].in[0]}));
  EXPECT_EQ(packed.nodes()[2].truth, 2u);
}

TEST_F(PackedLogic, WhatHasChangedSinceIsNotComputedAgain) {
  Logic logic;
  logic.places = row(0, 8);
  logic.record(0x6, {0, 1}, 2);
  logic.record(0x6, {3, 4}, 1);  // an input of the first one
  logic.record(0x6, {2, 5}, 6);
  runtime::PackedLogic packed(logic.items, logic.places);
  EXPECT_FALSE(packed.shorten_ways());
  logic.items[1].writes = {7};
  runtime::PackedLogic other(logic.items, logic.places);
  EXPECT_TRUE(other.shorten_ways());
  EXPECT_EQ(other.nodes()[2].in.size(), 3u);
}

}  // namespace
}  // namespace plc::test
