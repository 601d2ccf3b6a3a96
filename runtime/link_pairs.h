// Instructions of the interpreter that stand for several ones. Compile time.
//
// Those that stand for instructions whose words lie one behind the other take over the handler word of the first one:
// lists of instructions, jumps and the native engine see what was there before.
#pragma once

#include <cstdint>
#include <optional>

#include "runtime/interpreter.h"

namespace plc::runtime {

/// Rounds of a counted loop that may stand behind each other. A ROUNDS_.. in front of them does what the jumps between
/// them do to the loop budget, and, if nothing else counts, to the control variable. When fewer rounds are to come, it
/// leads elsewhere.
inline constexpr std::uint32_t kRoundsAtOnce = 8;

/// The end of a counted loop.
struct CountForm {
  ResolvedOp joined = ResolvedOp::kReturn;
  ResolvedOp rounds = ResolvedOp::kReturn;
  std::uint32_t bytes = 0;  ///< of the control variable
};
/// For a comparison and what counts before a LOOP_JUMP.
std::optional<CountForm> count_form(ResolvedOp compares, ResolvedOp counts);
/// For an AND and the comparison of its result with a third value.
std::optional<ResolvedOp> test_op(ResolvedOp masks, ResolvedOp compares);
/// What does `op` where a condition is TRUE.
std::optional<ResolvedOp> when_op(ResolvedOp op);
/// For a test of bits, a shift, and what mixes the shifted word where the test is TRUE.
std::optional<ResolvedOp> feedback_op(ResolvedOp tests, ResolvedOp shifts, ResolvedOp mixes);

}  // namespace plc::runtime
