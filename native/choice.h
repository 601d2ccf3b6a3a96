// Choice: two short stretches of code between which a condition chooses, as the two parts of an IF.
//
// Where both only compute, code may compute both and take one, instead of guessing which one it will be: wrong guesses
// cost more than a few instructions. In: the resolved instructions of one body. Out: where the parts are. Compile time,
// for all processors. Does not belong here: code.
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

/// Instructions of a body, from the first one to the one before the last.
struct Stretch {
  std::size_t first = 0, last = 0;
};

struct Choice {
  std::uint32_t condition = 0;  ///< operand, a BOOL
  bool value = false;           ///< `taken` is executed when the condition is this, `other` when it is not
  bool compares = false;        ///< the jump makes the condition first
  Stretch taken;
  Stretch other;        ///< perhaps nothing
  std::size_t end = 0;  ///< the instruction behind both
};

/// The choice that begins with jump number `i`. `jumps_to`: how many jumps go to a position.
std::optional<Choice> choice_at(const std::uint32_t* code, std::span<const runtime::LinkedInstruction> instructions,
                                std::size_t i, const std::function<std::size_t(std::uint32_t position)>& jumps_to);

/// The operands that the two parts write; nothing when they do more than to compute integers.
std::optional<std::vector<std::uint32_t>> written_by(const Emitter& emitter, const std::uint32_t* code,
                                                     std::span<const runtime::LinkedInstruction> instructions,
                                                     const Choice& choice);

/// Whether all that an instruction does is to write one integer that it computes from its operands, whatever these are;
/// returns the operand that is written.
std::optional<std::uint32_t> computes_integer(const Emitter& emitter, const Instruction& instruction);

/// By how much a call of a shift or rotation shifts, if that is a constant less than the width. `words`: of the call.
std::optional<std::uint64_t> plain_shift(const Emitter& emitter, const std::uint32_t* words);

}  // namespace plc::native
