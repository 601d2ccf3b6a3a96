// Value runs: instructions of one kind side by side, executed by one loop, as boolean logic is by its records.
//
// A record holds the operands of one instruction: out, then its inputs, as resolved operand words (link.h). In:
// records. Out: changed values. For the interpreter; which instructions may run side by side: arrange.h. RT.
#pragma once

#include <array>
#include <cstdint>

#include "runtime/interpreter/interpreter.h"

namespace plc::runtime {

/// Runs `count` records in order. Returns the word after them.
using ValueRun = const std::uint32_t* (*)(std::byte* table, std::uint32_t instance, const std::uint32_t* records,
                                          std::uint32_t count) noexcept;

/// An instruction that only computes a value.
struct ValueOp {
  ValueRun run[2] = {};    ///< by Addressing
  std::uint8_t first = 1;  ///< its word (handler word: 0) that is out; the inputs follow
  std::uint8_t inputs = 0;
  std::uint8_t out_bytes = 0;
  std::array<std::uint8_t, 3> in_bytes{};
};
/// Null when it does more, or calls.
const ValueOp* value_op(ResolvedOp op);

}  // namespace plc::runtime
