// Value runs: instructions of one kind side by side, executed by one loop, as boolean logic is by its records.
//
// A record holds the operands of one instruction: out, then its inputs, as resolved operand words (link.h). In:
// records. Out: changed values. For the interpreter; which instructions may stand side by side: arrange.h. RT.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "runtime/interpreter.h"

namespace plc::runtime {

/// Runs `count` records in order. Returns the word behind them.
using ValueRun = const std::uint32_t* (*)(std::byte* table, std::uint32_t instance, const std::uint32_t* records,
                                          std::uint32_t count) noexcept;

/// An operand of an instruction in a loop: where it lies in the first round, and how far away in the next one. No
/// initial values: a row of them is set up in each scan.
struct Stream {
  std::byte* at;
  std::ptrdiff_t step;  ///< bytes
};
/// Runs `count` rounds in order. Unused inputs are any.
using StreamRun = void (*)(const Stream& out, const Stream& in0, const Stream& in1, const Stream& in2,
                           std::uint32_t count) noexcept;

/// An instruction that only computes a value.
struct ValueOp {
  StreamRun stream = nullptr;
  ValueRun run[2] = {};    ///< by Addressing
  std::uint8_t first = 1;  ///< its word (handler word: 0) that is out; the inputs follow
  std::uint8_t inputs = 0;
  std::uint8_t out_bytes = 0;
  std::array<std::uint8_t, 3> in_bytes{};
};
/// in0 + round * in1 (`down`: less), of 32 or 16 bits: what a control variable is in each round.
StreamRun counting(bool wide, bool down);
/// What runs `product` and then `sum`, which adds its result to a variable, in one go: out + in0 * in1, the last
/// product in in2. Null when they are something else.
StreamRun sum_of_products(StreamRun product, StreamRun sum);
/// Null when it does more, or calls.
const ValueOp* value_op(ResolvedOp op);

}  // namespace plc::runtime
