// What the linker's passes share about operands: bytes in the table, and instructions by their size. Compile time.
#pragma once

#include <bit>
#include <cstdint>

#include "runtime/interpreter.h"

namespace plc::runtime {

/// Bytes from an operand on.
struct OperandRange {
  std::uint32_t operand = 0;
  std::uint64_t bytes = 0;
  [[nodiscard]] bool overlaps(const OperandRange& other) const {
    return operand < other.operand + other.bytes && other.operand < operand + bytes;
  }
  friend bool operator==(const OperandRange&, const OperandRange&) = default;
};

/// Of four instructions for values of 1, 2, 4 and 8 bytes, the first of which is `first`, that for `bytes`.
inline ResolvedOp of_size(ResolvedOp first, std::uint32_t bytes) {
  return static_cast<ResolvedOp>(static_cast<std::uint32_t>(first) +
                                 static_cast<std::uint32_t>(std::countr_zero(bytes)));
}
static_assert(static_cast<std::uint32_t>(ResolvedOp::kMove64) == static_cast<std::uint32_t>(ResolvedOp::kMove8) + 3 &&
              static_cast<std::uint32_t>(ResolvedOp::kSelect64) ==
                  static_cast<std::uint32_t>(ResolvedOp::kSelect8) + 3);

}  // namespace plc::runtime
