// If-conversion: short IFs in loops whose branches only compute integers.
//
// Code computes both branches and selects one result, because mispredicted jumps cost more than a few instructions. In:
// the resolved instructions of one body. Out: the short IF that begins with a jump, and the operands that its branches
// write. Compile time, for all processors. Does not belong here: code; IFs on BOOLs, which are boolean logic before
// there is resolved code (bytecode/codegen/if_conversion.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "native/translate.h"
#include "runtime/link/link.h"

namespace plc::native {

/// Instructions of a body, from the first one to the one before the last: one branch of an IF.
struct Branch {
  std::size_t first = 0, last = 0;
};

struct ShortIf {
  std::uint32_t condition = 0;  ///< operand, a BOOL
  bool value = false;           ///< `taken` is executed when the condition is this, `other` when it is not
  bool compares = false;        ///< the jump makes the condition first
  Branch taken;
  Branch other;         ///< perhaps nothing
  std::size_t end = 0;  ///< the instruction after both
};

/// The short_if that begins with jump number `i`. `jumps_to`: how many jumps go to a position.
std::optional<ShortIf> short_if_at(const std::uint32_t* code, std::span<const runtime::LinkedInstruction> instructions,
                                   std::size_t i, const std::function<std::size_t(std::uint32_t position)>& jumps_to);

/// The operands that the two parts write; nothing when they do more than to compute integers.
std::optional<std::vector<std::uint32_t>> written_by(const Emitter& emitter, const std::uint32_t* code,
                                                     std::span<const runtime::LinkedInstruction> instructions,
                                                     const ShortIf& short_if);

/// Whether all that an instruction does is to write one integer that it computes from its operands, whatever these are;
/// returns the operand that is written.
std::optional<std::uint32_t> computes_integer(const Emitter& emitter, const Instruction& instruction);

/// By how much a call of a shift or rotation shifts, if that is a constant less than the width. `words`: of the call.
std::optional<std::uint64_t> plain_shift(const Emitter& emitter, const std::uint32_t* words);

}  // namespace plc::native
