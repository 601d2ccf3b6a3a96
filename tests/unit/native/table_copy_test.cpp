// The copy of a table: it finds what differs, each byte once, and follows only where it was told to.
#include "native/table_copy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "tests/support/random_values.h"

namespace plc::test {
namespace {

using native::TableCopy;
using Area = TableCopy::Area;

constexpr std::uint32_t kLine = TableCopy::kLine;

/// A table, its copy, and what the copy ought to hold. `bool`: without instructions that not all processors have.
class TableCopyTest : public testing::TestWithParam<bool> {
 protected:
  /// Bytes [0, 128), bits [512, 1280), bytes [1280, 1472), which are no whole block.
  const std::vector<Area> areas{{0, 2, 0, false}, {512, 12, 128, true}, {1280, 3, 896, false}};
  static constexpr std::uint32_t kBytes = 1472;

  struct Change {
    std::uint32_t cell = 0;
    std::uint32_t toggled = 0;
    bool operator==(const Change&) const = default;
  };

  static bool is_bit(std::uint32_t offset) { return offset >= 512 && offset < 1280; }
  [[nodiscard]] bool is_watched(std::uint32_t offset) const {
    return std::any_of(areas.begin(), areas.end(),
                       [&](const Area& a) { return offset >= a.offset && offset < a.offset + a.lines * kLine; });
  }
  [[nodiscard]] std::uint32_t cell(std::uint32_t offset) const {
    std::uint32_t found = 0;
    for (const Area& a : areas) found = offset >= a.offset ? a.cells + offset - a.offset : found;
    return found;
  }
  [[nodiscard]] bool differs(std::uint32_t offset) const {
    const std::byte change = table[offset] ^ known[offset];
    return (is_bit(offset) ? change & std::byte{1} : change) != std::byte{0};
  }
  /// What for_each_change is to visit, by offset.
  [[nodiscard]] std::map<std::uint32_t, Change> expected() const {
    std::map<std::uint32_t, Change> changes;
    for (std::uint32_t at = 0; at < kBytes; ++at) {
      const auto toggled = static_cast<std::uint32_t>((table[at] ^ known[at]) & std::byte{1});
      if (is_watched(at) && differs(at)) changes[at] = {cell(at), toggled};
    }
    return changes;
  }
  /// Visits at most so many, and expects that these are among those expected, once each.
  void visit(std::size_t most = kBytes) {
    const std::map<std::uint32_t, Change> all = expected();
    std::map<std::uint32_t, Change> seen;
    bool stopped = false;
    copy.for_each_change([&](const Area& area, std::uint32_t distance, std::uint32_t toggled) {
      EXPECT_FALSE(stopped);
      stopped = seen.size() == most;
      if (stopped) return false;
      const std::uint32_t offset = area.offset + distance;
      EXPECT_TRUE(seen.emplace(offset, Change{area.cells + distance, toggled}).second) << offset << " again";
      return true;
    });
    EXPECT_EQ(seen.size(), std::min(most, all.size()));
    EXPECT_EQ(stopped, all.size() > most);
    for (const auto& [offset, change] : seen) {
      ASSERT_TRUE(all.contains(offset)) << offset << " did not change";
      EXPECT_EQ(change, all.at(offset)) << offset;
      known[offset] = table[offset];
    }
  }

  std::vector<std::byte> table = std::vector<std::byte>(kBytes);
  std::vector<std::byte> known = std::vector<std::byte>(kBytes);
  TableCopy copy{table, areas, GetParam()};
};

TEST_P(TableCopyTest, BeginsWithZeros) {
  for (const std::uint32_t at : {0u, 127u, 512u, 1279u, 1471u}) table[at] = std::byte{1};
  EXPECT_EQ(expected().size(), 5u);
  visit();
  visit();
}

TEST_P(TableCopyTest, FindsEachByteWhereverItIs) {
  for (std::uint32_t at = 0; at < kBytes; ++at) {
    table[at] = std::byte{1};
    visit();
    table[at] = std::byte{0};
    visit();
  }
}

TEST_P(TableCopyTest, OfABoolOnlyBit0Counts) {
  table[600] = std::byte{0xfe};
  table[100] = std::byte{0xfe};
  EXPECT_EQ(expected().size(), 1u);
  visit();
  table[600] = std::byte{0xff};
  EXPECT_EQ(expected().size(), 1u);
  visit();
}

TEST_P(TableCopyTest, WhatIsLeftIsFoundLater) {
  Random random(7);
  for (int round = 0; round < 300; ++round) {
    const std::size_t writes = random.below(40);
    for (std::size_t n = 0; n < writes; ++n) {
      const auto at = static_cast<std::uint32_t>(random.below(kBytes));
      table[at] = static_cast<std::byte>(is_bit(at) ? random.below(2) : random.below(256));
    }
    visit(random.below(30));
  }
  visit();
}

TEST_P(TableCopyTest, BytesAreTakenOneByOne) {
  Random random(8);
  for (int round = 0; round < 2000; ++round) {
    const auto at = static_cast<std::uint32_t>(random.below(kBytes));
    table[at] = static_cast<std::byte>(is_bit(at) ? random.below(2) : random.below(256));
    if (!is_watched(at)) continue;
    EXPECT_EQ(copy.differs(at, 1), differs(at)) << at;
    EXPECT_EQ(copy.toggled(at), static_cast<std::uint32_t>((table[at] ^ known[at]) & std::byte{1})) << at;
    if (random.below(2) == 0) continue;
    if (random.below(2) == 0) {
      copy.take(at, 1);
    } else {
      copy.writer().set(at, table[at]);
    }
    known[at] = table[at];
    EXPECT_FALSE(copy.differs(at, 1)) << at;
  }
  visit();
}

TEST_P(TableCopyTest, SeveralBytesDifferIfOneDoes) {
  for (const std::uint32_t begin : {40u, 700u, 1400u}) {
    for (std::uint32_t at = begin; at < begin + 8; ++at) {
      EXPECT_FALSE(copy.differs(begin, 8));
      table[at] ^= std::byte{1};
      EXPECT_TRUE(copy.differs(begin, 8)) << at;
      copy.take(begin, 8);
      known[at] = table[at];
    }
  }
  visit();
}

INSTANTIATE_TEST_SUITE_P(Instructions, TableCopyTest, testing::Values(false, true),
                         [](const auto& which) { return which.param ? "Baseline" : "All"; });

}  // namespace
}  // namespace plc::test
