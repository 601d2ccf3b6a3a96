#include "native/table_copy.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include <algorithm>
#include <cstring>
#include <utility>

namespace plc::native {
namespace {

constexpr std::uint32_t kLine = TableCopy::kLine;
constexpr std::uint32_t kBlock = TableCopy::kBlock;
constexpr std::uint32_t kRow = TableCopy::kRow;

// RT:
std::uint32_t next_line(const std::byte* a, const std::byte* b, std::uint32_t line, std::uint32_t count) noexcept {
  const auto at = [&](const std::byte* bytes) { return bytes + std::size_t{line} * kLine; };
  while (line < count && std::memcmp(at(a), at(b), kLine) == 0) ++line;
  return line;
}

// RT:
std::uint32_t next_block(const std::byte* table, const std::byte* bits, std::uint32_t block, std::uint32_t count,
                         std::uint64_t (&differ)[4]) noexcept {
  constexpr std::uint64_t kBit0 = 0x0101010101010101u;
  for (; block < count; ++block) {
    const std::byte* const rows = table + std::size_t{block} * kBlock;
    std::uint64_t any = 0;
    for (std::uint32_t i = 0; i < 4; ++i) {
      std::uint64_t packed = 0;
      for (std::uint32_t row = 8; row-- > 0;) {
        packed = packed * 2 + (runtime::load<std::uint64_t>(rows + row * kRow + i * 8) & kBit0);
      }
      differ[i] = packed ^ runtime::load<std::uint64_t>(bits + std::size_t{block} * kRow + i * 8);
      any |= differ[i];
    }
    if (any != 0) break;
  }
  return block;
}

#if defined(__x86_64__)
/// Where a and b differ within a line.
// RT:
[[gnu::target("avx2"), gnu::always_inline]] inline __m256i differences(const std::byte* a,
                                                                       const std::byte* b) noexcept {
  const auto* const x = reinterpret_cast<const __m256i*>(a);
  const auto* const y = reinterpret_cast<const __m256i*>(b);
  const __m256i low = _mm256_xor_si256(_mm256_loadu_si256(x), _mm256_loadu_si256(y));
  const __m256i high = _mm256_xor_si256(_mm256_loadu_si256(x + 1), _mm256_loadu_si256(y + 1));
  return _mm256_or_si256(low, high);
}
// The same, four times as fast: mostly nothing differs for many lines, of which four are looked at together.
// RT:
[[gnu::target("avx2")]] std::uint32_t next_line_avx2(const std::byte* a, const std::byte* b, std::uint32_t line,
                                                     std::uint32_t count) noexcept {
  for (; line + 4 <= count; line += 4) {
    const std::byte* const x = a + std::size_t{line} * kLine;
    const std::byte* const y = b + std::size_t{line} * kLine;
    const __m256i first = _mm256_or_si256(differences(x, y), differences(x + kLine, y + kLine));
    const __m256i second =
        _mm256_or_si256(differences(x + 2 * kLine, y + 2 * kLine), differences(x + 3 * kLine, y + 3 * kLine));
    const __m256i any = _mm256_or_si256(first, second);
    if (_mm256_testz_si256(any, any) == 0) break;
  }
  for (; line < count; ++line) {
    const __m256i any = differences(a + std::size_t{line} * kLine, b + std::size_t{line} * kLine);
    if (_mm256_testz_si256(any, any) == 0) break;
  }
  return line;
}

// RT:
[[gnu::target("avx2")]] std::uint32_t next_block_avx2(const std::byte* table, const std::byte* bits,
                                                      std::uint32_t block, std::uint32_t count,
                                                      std::uint64_t (&differ)[4]) noexcept {
  static_assert(kRow == sizeof(__m256i));
  const __m256i bit0 = _mm256_set1_epi8(1);
  for (; block < count; ++block) {
    const auto* const rows = reinterpret_cast<const __m256i*>(table + std::size_t{block} * kBlock);
    __m256i packed = _mm256_and_si256(_mm256_loadu_si256(rows + 7), bit0);
#pragma GCC unroll 7
    for (int row = 6; row >= 0; --row) {
      packed = _mm256_add_epi8(packed, packed);
      packed = _mm256_add_epi8(packed, _mm256_and_si256(_mm256_loadu_si256(rows + row), bit0));
    }
    const auto* const before = reinterpret_cast<const __m256i*>(bits + std::size_t{block} * kRow);
    const __m256i any = _mm256_xor_si256(packed, _mm256_loadu_si256(before));
    if (_mm256_testz_si256(any, any) != 0) continue;
    std::memcpy(differ, &any, sizeof(any));
    break;
  }
  return block;
}
#endif

constexpr std::size_t blocks_in(std::size_t bytes) { return (bytes + kBlock - 1) / kBlock; }

}  // namespace

TableCopy::TableCopy(std::span<const std::byte> table, std::vector<Area> areas, [[maybe_unused]] bool baseline)
    : table_(table.data()),
      areas_(std::move(areas)),
      kinds_(blocks_in(table.size())),
      bytes_(blocks_in(table.size()) * kBlock),
      bits_(blocks_in(table.size()) * kRow),
      next_block_(next_block),
      next_line_(next_line) {
  for (const Area& area : areas_) {
    if (area.bits) std::fill_n(kinds_.begin() + area.offset / kBlock, area.lines / kBlockLines, std::uint8_t{1});
  }
#if defined(__x86_64__)
  if (baseline || __builtin_cpu_supports("avx2") == 0) return;
  next_block_ = next_block_avx2;
  next_line_ = next_line_avx2;
#endif
}

// RT:
bool TableCopy::differs(std::uint32_t offset, std::uint32_t bytes) const noexcept {
  if (kinds_[offset / kBlock] == 0) return std::memcmp(table_ + offset, bytes_.data() + offset, bytes) != 0;
  for (std::uint32_t at = offset; at < offset + bytes; ++at) {
    if (toggled(at) != 0) return true;
  }
  return false;
}

// RT:
std::uint32_t TableCopy::toggled(std::uint32_t offset) const noexcept {
  const bool is_byte = kinds_[offset / kBlock] == 0;
  const std::byte before = is_byte ? bytes_.data()[offset] : bits_.data()[packed_at(offset)] >> offset / kRow % 8;
  return static_cast<std::uint32_t>((table_[offset] ^ before) & std::byte{1});
}

// RT:
void TableCopy::take(std::uint32_t offset, std::uint32_t bytes) noexcept {
  const Writer to = writer();
  for (std::uint32_t at = offset; at < offset + bytes; ++at) to.set(at, table_[at]);
}

}  // namespace plc::native
