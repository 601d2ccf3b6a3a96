// Packed runs: boolean logic whose variables fit into one or two words of 64 bits, one bit each.
//
// The bytes of up to two windows of the table become bits, which stay in registers while the logic runs. A record of
// it then needs no load of its inputs: PEXT brings the bits of those together, which number the place in its truth
// table. Records stand in chunks of four. All of a chunk read the bits as they were before the one or two chunks in
// front of it, so that two or three are under way at a time; the linker (link_packed.h) places records where that
// holds.
//
// Two words become one for each chunk: a column, i.e. a bit in both words, is that of the first or that of the second
// one. The bytes of the second window are in such an order that no chunk needs both (packed_columns.h).
//
// Logic between which other instructions stand is several runs: the first one fetches the bits, the last one puts them
// back, and in between they lie in scratch memory; what the other instructions use is fetched and stored byte by byte.
//
// In: words as laid out below. Out: changed bytes, those of variables that were written only. For processors with BMI2
// and AVX2. Does not belong here: which runs are packed. RT.
#pragma once

#include <cstddef>
#include <cstdint>

#include "runtime/value_runs.h"

namespace plc::runtime {

inline constexpr std::uint32_t kPackedWindowBytes = 64;  ///< as many as a word has bits
inline constexpr std::uint32_t kChunkRecords = 4;
inline constexpr std::size_t kMostPackedWords = 2;

/// How the runs of a stretch are packed.
struct PackedForm {
  std::size_t words = 1;   ///< of bits: 1 or 2
  std::int32_t delay = 2;  ///< 2 or 3: results can be read that many chunks later
};

/// Where bits lie between two runs.
inline constexpr std::uint32_t kPackedStateBytes = kMostPackedWords * sizeof(std::uint64_t);

/// What a packed run begins with. Behind it: with two words PackedOrder; gathers, scatters (PackedBit), chunks.
struct PackedHeader {
  std::uint32_t window[kMostPackedWords] = {};    ///< resolved operand of each word's first byte
  std::uint32_t windows = 0;                      ///< words that have one
  std::uint32_t gathers = 0;                      ///< bytes that are read one by one, first
  std::uint32_t scatters = 0;                     ///< ..that are written, last
  std::uint32_t state = 0;                        ///< resolved operand of kPackedStateBytes
  std::uint32_t begins = 1;                       ///< 0: the bits lie in the state
  std::uint32_t ends = 1;                         ///< 0: the bits go to the state
  std::uint64_t gathered[kMostPackedWords] = {};  ///< bits of `gathers`
  std::uint64_t written[kMostPackedWords] = {};   ///< bytes of the window (not bits) that are written where it ends
};
static_assert(sizeof(PackedHeader) == 64);

/// Which byte of the second window each bit of its word is, and the other way round; in lanes of 16, from 0 in each.
struct PackedOrder {
  std::uint8_t byte_of_bit[kPackedWindowBytes] = {};
  std::uint8_t bit_of_byte[kPackedWindowBytes] = {};
};

/// A byte of the table and its bit.
struct PackedBit {
  std::uint32_t operand = 0;  ///< resolved
  std::uint32_t bit = 0;      ///< from the first word's bit 0 on
};

struct PackedRecord {
  std::uint64_t in = 0;     ///< bits that are inputs: the index, from the lowest one on
  std::uint64_t truth = 0;  ///< one bit for each index
};
/// Results become the bits of `out`: the last record's is the lowest one of the first word. Records that fill up the
/// chunk stand in front.
template <std::size_t kWords>
struct PackedChunk {
  std::uint64_t out = 0;
  PackedRecord records[kChunkRecords];
};
template <>
struct PackedChunk<2> {
  std::uint64_t out = 0;
  PackedRecord records[kChunkRecords];
  std::uint64_t second_out = 0;
  std::uint64_t from_first = 0;     ///< columns whose bit is the first word's
  std::uint64_t first_outputs = 0;  ///< how many of `out`
};
static_assert(sizeof(PackedChunk<1>) == 72 && sizeof(PackedChunk<2>) == 96);

/// What runs `count` chunks of this form. Null when this processor has no fast way to do it.
ValueRun packed_run(PackedForm form);

}  // namespace plc::runtime
