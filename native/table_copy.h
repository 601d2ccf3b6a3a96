// TableCopy: a task's table as it was, and where the table is another one now.
//
// In: the table and the areas of it that are watched. Out: the bytes in which the two differ; the copy follows byte by
// byte. Areas that hold nothing but BOOLs are kept as bits, a byte for eight of them, since the table and its copy are
// read in every scan and ought to stay in the nearest cache together. All of it is RT but set-up. Does not belong here:
// who reads or writes a byte (change_tracker.h).
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "runtime/memory/table.h"
#include "runtime/operations.h"

namespace plc::native {

class TableCopy {
 public:
  static constexpr std::uint32_t kLine = 64;
  /// BOOLs are compared by blocks of so many lines, each of eight rows: of the bytes at one place of all rows the copy
  /// keeps one, and the row is the number of the bit.
  static constexpr std::uint32_t kBlockLines = 4;
  static constexpr std::uint32_t kBlock = kBlockLines * kLine;
  static constexpr std::uint32_t kRow = kBlock / 8;

  /// Cache lines of the table that lie behind one another.
  struct Area {
    std::uint32_t offset = 0;
    std::uint32_t lines = 0;
    std::uint32_t cells = 0;  ///< for its owner
    bool bits = false;        ///< whole blocks, and bit 0 of each byte is all there is to know
  };

  /// All zeros. `table` outlives the copy. `baseline`: as in CompileOptions.
  TableCopy(std::span<const std::byte> table, std::vector<Area> areas, bool baseline);

  /// Calls visit(area, distance from its start, 1 if bit 0 differs and else 0) for each byte in which the table
  /// differs, and copies it. If that returns false, this byte and those behind it are left for later.
  template <class Visit>
  void for_each_change(Visit&& visit) noexcept;

  /// Whether any of these bytes differ; all of them in areas.
  [[nodiscard]] bool differs(std::uint32_t offset, std::uint32_t bytes) const noexcept;
  /// 1 if bit 0 of a byte differs, else 0.
  [[nodiscard]] std::uint32_t toggled(std::uint32_t offset) const noexcept;
  /// Copies bytes.
  void take(std::uint32_t offset, std::uint32_t bytes) noexcept;

  /// Copies single BOOLs. A value of its own, so that a loop keeps it in registers.
  struct Writer {
    const std::uint8_t* kinds;
    std::byte* bits;
    std::byte* bytes;
    [[gnu::always_inline]] void set(std::uint32_t offset, std::byte value) const noexcept {
      if (kinds[offset / kBlock] == 0) {
        bytes[offset] = value;
        return;
      }
      std::byte& packed = bits[packed_at(offset)];
      const std::uint32_t row = offset / kRow % 8;
      packed = (packed & ~(std::byte{1} << row)) | (value & std::byte{1}) << row;
    }
  };
  Writer writer() noexcept { return {kinds_.data(), bits_.data(), bytes_.data()}; }

 private:
  static constexpr std::uint32_t kWord = sizeof(std::uint64_t);

  /// for_each_change in one area. False: `visit` was.
  template <class Visit>
  bool visit_bits(const Area& area, Visit&& visit) noexcept;
  template <class Visit>
  bool visit_bytes(const Area& area, Visit&& visit) noexcept;

  static constexpr std::uint32_t packed_at(std::uint32_t offset) { return offset / kBlock * kRow + offset % kRow; }

  const std::byte* table_;
  std::vector<Area> areas_;          ///< ascending
  std::vector<std::uint8_t> kinds_;  ///< by block: 1 when it is kept as bits
  runtime::TableMemory bytes_;
  runtime::TableMemory bits_;  ///< kRow bytes for each block
  /// The first block from `block` on, of `count`, in which the bits differ from those of the table, and the bits that
  /// do; count when there is none.
  std::uint32_t (*next_block_)(const std::byte* table, const std::byte* bits, std::uint32_t block, std::uint32_t count,
                               std::uint64_t (&differ)[4]) noexcept;
  /// The first line from `line` on, of `count`, in which the two differ; count when there is none.
  std::uint32_t (*next_line_)(const std::byte* a, const std::byte* b, std::uint32_t line, std::uint32_t count) noexcept;
};

// RT:
template <class Visit>
void TableCopy::for_each_change(Visit&& visit) noexcept {
  for (const Area& area : areas_) {
    if (!(area.bits ? visit_bits(area, visit) : visit_bytes(area, visit))) return;
  }
}

// RT:
template <class Visit>
bool TableCopy::visit_bits(const Area& area, Visit&& visit) noexcept {
  const std::byte* const now = table_ + area.offset;
  std::byte* const before = bits_.data() + packed_at(area.offset);
  const std::uint32_t blocks = area.lines / kBlockLines;
  std::uint64_t differ[4];
  for (std::uint32_t block = 0; (block = next_block_(now, before, block, blocks, differ)) < blocks; ++block) {
    // Mostly one word of the four: found without a jump for each.
    std::uint32_t words = 0;
    for (std::uint32_t i = 0; i < 4; ++i) words |= std::uint32_t{differ[i] != 0} << i;
    for (; words != 0; words &= words - 1) {
      const auto word = static_cast<std::uint32_t>(std::countr_zero(words));
      for (std::uint64_t bits = differ[word]; bits != 0; bits &= bits - 1) {
        const auto bit = static_cast<std::uint32_t>(std::countr_zero(bits));
        const std::uint32_t place = word * kWord + bit / 8;
        if (!visit(area, block * kBlock + bit % 8 * kRow + place, 1u)) return false;
        before[block * kRow + place] ^= std::byte{1} << bit % 8;
      }
    }
  }
  return true;
}

// RT:
template <class Visit>
bool TableCopy::visit_bytes(const Area& area, Visit&& visit) noexcept {
  const std::byte* const now = table_ + area.offset;
  std::byte* const before = bytes_.data() + area.offset;
  for (std::uint32_t line = 0; (line = next_line_(now, before, line, area.lines)) < area.lines; ++line) {
    for (std::uint32_t word = line * kLine; word < (line + 1) * kLine; word += kWord) {
      auto differ = runtime::load<std::uint64_t>(now + word) ^ runtime::load<std::uint64_t>(before + word);
      while (differ != 0) {
        const auto byte = static_cast<std::uint32_t>(std::countr_zero(differ)) / 8;
        if (!visit(area, word + byte, static_cast<std::uint32_t>(differ >> byte * 8 & 1u))) return false;
        before[word + byte] = now[word + byte];
        differ &= ~(std::uint64_t{0xff} << byte * 8);
      }
    }
  }
  return true;
}

}  // namespace plc::native
