// Bytes of values as pointers see them: read and written one by one, whatever leaves they lie in.
//
// In: a value in a table and its type. Out: bytes; or changed leaves, each brought back into its range: a BOOL is 0 or
// 1, a string ends at its first zero, what has limits takes the nearest of them, a NaN is the canonical one. All of it
// is RT: bounded by the bytes asked for, and by the capacity of the strings they lie in. Does not belong here: which
// value a pointer leads to (objects.h).
#pragma once

#include <cstddef>
#include <cstdint>

#include "runtime/pointers/packed_types.h"

namespace plc::runtime {

/// Whether bytes `offset` to `offset` + `bytes` of a value of `type`, all inside it, are open to pointers.
bool is_open(const PackedTypes& types, std::uint32_t type, std::uint32_t offset, std::uint32_t bytes) noexcept;
/// Copies open bytes of the value at `value` to `to`. Gaps between fields are zeros.
void read_packed(const PackedTypes& types, std::uint32_t type, const std::byte* value, std::uint32_t offset,
                 std::uint32_t bytes, std::byte* to) noexcept;
/// Whether what a TIME or date holds beyond the steps that pointers see stays when its steps stay, or is new.
enum class Finer : std::uint8_t { kStays, kNew };
/// The other way. What is written to a gap, or to the zero at the end of a string's memory, is dropped.
void write_packed(const PackedTypes& types, std::uint32_t type, std::byte* value, std::uint32_t offset,
                  std::uint32_t bytes, const std::byte* from, Finer finer = Finer::kStays) noexcept;

}  // namespace plc::runtime
