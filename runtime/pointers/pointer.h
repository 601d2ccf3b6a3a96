// Pointer: the value of POINTER TO, 64 bits that programs compute with as with a ULINT: object and byte offset.
//
// Bits 53..63 tag as in handles (handle.h): 0 = null, 1 = in the copy of the global table, 2 + n = in the rest of the
// table of task n. Bits 32..52 number of the object. Bits 0..31 signed byte offset from its start, in the layout that
// SIZEOF states; a negative one borrows from the number, so that p + n is one addition. Programs may make any pointer:
// it is looked at where it is used (objects.h), and nowhere before. Does not belong here: what an object is.
#pragma once

#include <cstdint>

namespace plc::runtime {

struct Pointer {
  std::uint64_t bits = 0;

  /// Objects of one task's table, or of the global table.
  static constexpr std::uint32_t kMaxObjects = 1u << 21;

  static constexpr Pointer make(std::uint64_t tag, std::uint32_t object, std::int64_t offset) {
    return {(tag << 53 | std::uint64_t{object} << 32) + static_cast<std::uint64_t>(offset)};
  }
  /// Tag and number in one: the bits above the offset.
  [[nodiscard]] constexpr std::uint32_t object_bits() const {
    return static_cast<std::uint32_t>((bits + 0x80000000u) >> 32);
  }
  [[nodiscard]] constexpr std::uint64_t tag() const { return object_bits() >> 21; }
  [[nodiscard]] constexpr std::uint32_t object() const { return object_bits() & (kMaxObjects - 1); }
  [[nodiscard]] constexpr std::int64_t offset() const {
    return static_cast<std::int64_t>(bits - (std::uint64_t{object_bits()} << 32));
  }
};
static_assert(Pointer::make(2, 5, -1).object() == 5 && Pointer::make(2, 5, -1).offset() == -1);

}  // namespace plc::runtime
