// Packing of values into requests: by hand, and against the fewest that a search finds.
#include "io-drivers/modbus-client/plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>

namespace plc::modbus_client {
namespace {

constexpr auto kHolding = ModbusTable::kHoldingRegisters;

/// "holding-registers 0+4 10ms" and so on; ~ marks gaps.
std::string text_of(const std::vector<Block>& blocks) {
  std::string text;
  for (const Block& block : blocks) {
    text += std::string(io::modbus_table_text(block.table)) + ' ' + std::to_string(block.first) + '+' +
            std::to_string(block.count) + (block.gaps ? "~" : "") + '@' + std::to_string(block.period_ns) + '\n';
  }
  return text;
}

TEST(Plan, NeighboursShareARequest) {
  const Want wants[] = {{kHolding, 2, 2, 10},
                        {kHolding, 0, 2, 10},
                        {kHolding, 4, 1, 20},
                        {ModbusTable::kCoils, 7, 1, 10},
                        {ModbusTable::kCoils, 6, 1, 10}};
  EXPECT_EQ(text_of(plan(wants, {})), "coils 6+2@10\nholding-registers 0+4@10\nholding-registers 4+1@20\n");
  EXPECT_EQ(plan(wants, {})[1].wants, (std::vector<std::uint32_t>{1, 0}));
}

TEST(Plan, GapsAreReadAlongAsFarAsAllowed) {
  const Want wants[] = {{kHolding, 0, 1, 1},
                        {kHolding, 9, 1, 1},
                        {kHolding, 19, 1, 1},
                        {ModbusTable::kCoils, 0, 1, 1},
                        {ModbusTable::kCoils, 129, 1, 1}};
  EXPECT_EQ(text_of(plan(wants, {.gap = 8})), "coils 0+130~@1\nholding-registers 0+10~@1\nholding-registers 19+1@1\n");
  EXPECT_EQ(plan(wants, {.gap = 0}).size(), 5u);
}

TEST(Plan, LimitsSplitBetweenValuesOnly) {
  std::vector<Want> wants;
  for (std::uint16_t i = 0; i < 100; ++i) wants.push_back({kHolding, static_cast<std::uint16_t>(2 * i), 2, 1});
  EXPECT_EQ(text_of(plan(wants, {})), "holding-registers 0+124@1\nholding-registers 124+76@1\n");
  EXPECT_EQ(plan(wants, {.registers = 1}).size(), 100u) << "a longer value has a block of its own";
}

TEST(Plan, ValuesMayOverlap) {
  const Want wants[] = {{kHolding, 10, 4, 1}, {kHolding, 11, 1, 1}, {kHolding, 11, 1, 1}, {kHolding, 14, 1, 1}};
  EXPECT_EQ(text_of(plan(wants, {})), "holding-registers 10+5@1\n");
}

TEST(Plan, TheLastAddressIsReached) {
  const Want wants[] = {{kHolding, 65532, 4, 1}, {kHolding, 65531, 1, 1}};
  EXPECT_EQ(text_of(plan(wants, {})), "holding-registers 65531+5@1\n");
}

/// The fewest requests, by trying every place to split.
std::size_t fewest(const std::vector<Want>& sorted, const Limits& limits) {
  std::vector<std::size_t> best(sorted.size() + 1, 0);
  for (std::size_t end = 1; end <= sorted.size(); ++end) {
    best[end] = sorted.size() + 1;
    int last = 0, span_end = 0;
    for (std::size_t begin = end; begin-- > 0;) {
      last = std::max(last, sorted[begin].first + sorted[begin].count);
      span_end = last;
      bool possible = span_end - sorted[begin].first <= limits.registers || end - begin == 1;
      int reached = sorted[begin].first + sorted[begin].count;
      for (std::size_t i = begin + 1; i < end; ++i) {
        possible = possible && sorted[i].first <= reached + limits.gap;
        reached = std::max(reached, sorted[i].first + sorted[i].count);
      }
      if (possible) best[end] = std::min(best[end], best[begin] + 1);
    }
  }
  return best[sorted.size()];
}

TEST(Plan, NoOtherPackingHasFewerRequests) {
  std::mt19937 random(11);
  for (int round = 0; round < 300; ++round) {
    std::vector<Want> wants;
    const Limits limits = {.registers = static_cast<std::uint16_t>(4 + random() % 20),
                           .bits = 2000,
                           .gap = static_cast<std::uint16_t>(random() % 6)};
    for (std::size_t i = 0; i < 1 + random() % 30; ++i) {
      wants.push_back(
          {kHolding, static_cast<std::uint16_t>(random() % 150), static_cast<std::uint16_t>(1u << random() % 3), 1});
    }
    const auto blocks = plan(wants, limits);
    std::ranges::stable_sort(wants, {}, &Want::first);
    EXPECT_LE(blocks.size(), fewest(wants, limits)) << round;
    std::size_t covered = 0;
    for (const Block& block : blocks) {
      covered += block.wants.size();
      EXPECT_LE(block.count, limits.registers);
    }
    EXPECT_EQ(covered, wants.size());
  }
}

}  // namespace
}  // namespace plc::modbus_client
