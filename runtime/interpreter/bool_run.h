// Boolean logic as data: the loops over the look-up records of a BOOL_RUN.
//
// A record is a truth table over up to five BOOLs; evaluating one takes no branch, so the cost is flat in the size of
// the program and in how its inputs change. Records run in order and may read what earlier ones wrote. Short records
// (16 bytes) hold offsets within a 64 KiB window; the linker cuts runs into windows and picks the four-input loop for
// basic blocks whose tables ignore the fifth input: the loops are bound by loads, and it makes two fewer. Measured: one
// pair of offsets for four inputs, two for five; with more of them the steps that part them take longer than the loads,
// as they do everywhere on a processor whose other thread is busy.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "runtime/interpreter/repeat.h"

namespace plc::runtime {

struct ShortRecord {
  std::uint32_t truth = 0;
  std::uint16_t out = 0;
  std::uint16_t in[5] = {};
};
static_assert(sizeof(ShortRecord) == 16);

/// Operands are resolved operand words (link.h).
struct GeneralRecord {
  std::uint32_t truth = 0;
  std::uint32_t out = 0;
  std::uint32_t in[5] = {};
};
static_assert(sizeof(GeneralRecord) == 28);

inline constexpr std::uint32_t kShortRecordWords = sizeof(ShortRecord) / 4;
inline constexpr std::uint32_t kGeneralRecordWords = sizeof(GeneralRecord) / 4;

/// True when a five-input truth table does not depend on its last input.
constexpr bool ignores_last_input(std::uint32_t truth) { return (truth >> 16) == (truth & 0xffffu); }

template <class T>
inline T load_field(const unsigned char* at) noexcept {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

/// The bit `index` mod 32 of `truth`.
inline bool bit_of(std::uint32_t truth, std::uint32_t index) noexcept {
#if defined(__x86_64__) && defined(__GCC_ASM_FLAG_OUTPUTS__)
  // One step; a shift by a variable is three, and compilers make that of whatever is written below.
  bool bit;
  asm("bt %2, %1" : "=@ccc"(bit) : "r"(truth), "r"(index));
  return bit;
#else
  return ((truth >> (index & 31u)) & 1u) != 0;
#endif
}

/// Runs `count` short records at `records` (4-byte aligned) on the BOOLs at `window`. RT.
template <int kInputs>
inline void run_short(std::uint8_t* window, const std::uint32_t* records, std::uint32_t count) noexcept {
  const auto* at = reinterpret_cast<const unsigned char*>(records);
  repeat<sizeof(ShortRecord)>(
      at, count, [window](const unsigned char* record) __attribute__((always_inline)) {
        // Field by field: a copy of the whole record becomes two 64-bit loads and shifts, which is slower.
        const auto bool_at = [window, record](std::size_t field) -> std::uint32_t {
          return window[load_field<std::uint16_t>(record + field)];
        };
        // Two offsets in one load where they lie in one word: the loop is bound by its loads.
        const auto pair_at = [window](std::uint32_t offsets) -> std::uint32_t {
          return window[offsets & 0xffffu] + 2u * window[offsets >> 16];
        };
        constexpr std::size_t kIn = offsetof(ShortRecord, in);
        // The sums become lea instructions; ORs of shifts would be twice as many.
        if constexpr (kInputs == 5) {
          const std::uint32_t index = bool_at(kIn) + 2 * pair_at(load_field<std::uint32_t>(record + kIn + 2)) +
                                      8 * pair_at(load_field<std::uint32_t>(record + kIn + 6));
          window[load_field<std::uint16_t>(record + offsetof(ShortRecord, out))] =
              static_cast<std::uint8_t>(bit_of(load_field<std::uint32_t>(record), index));
        } else {
          // Half of the table is all of it, and the half next to `out` comes with it. First of all: loads of the next
          // records wait for nothing when it is known early where this one stores.
          static_assert(offsetof(ShortRecord, out) == offsetof(ShortRecord, truth) + 4);
          const auto half_and_out = load_field<std::uint32_t>(record + offsetof(ShortRecord, truth) + 2);
          std::uint64_t out = half_and_out >> 16;
          asm volatile("" : "+r"(out));  // here, not where it is used
          std::uint32_t index;
          if constexpr (kInputs == 2) {
            index = bool_at(kIn) + 2 * bool_at(kIn + 2);
          } else {
            index = bool_at(kIn) + 2 * pair_at(load_field<std::uint32_t>(record + kIn + 2)) + 8 * bool_at(kIn + 6);
          }
          window[out] = static_cast<std::uint8_t>(bit_of(half_and_out, index));
        }
      });
}

/// Runs one general record; `bool_at` gives the place of an operand. RT.
template <class Place>
inline void run_general(const std::uint32_t* record, Place bool_at) noexcept {
  const std::uint32_t index = *bool_at(record[2]) + 2u * *bool_at(record[3]) +
                              4u * (*bool_at(record[4]) + 2u * *bool_at(record[5])) + 16u * *bool_at(record[6]);
  *bool_at(record[1]) = static_cast<std::uint8_t>(bit_of(record[0], index));
}

}  // namespace plc::runtime
