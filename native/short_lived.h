// Short-lived results: those that the next instruction takes from their register, and that are overwritten before
// anybody else looks. Code does not store them.
//
// In: the resolved code of one body, executed as a whole in every scan that gets there. Out: for each of its
// instructions, the operand that it need not store. Drawn arithmetic is full of them: every block leaves its result in
// a temporary of the frame that the next chain uses again. A result that nobody overwrites is stored, even if nobody
// reads it: tables are the same after every scan, and whenever one ends early. Compile time, for all processors. Does
// not belong here: registers and code.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "native/operation.h"
#include "runtime/link/link.h"

namespace plc::native {

/// By instruction of `body`, which has no operands relative to an instance: a place may have one of these and another.
using ShortLived = std::vector<std::optional<std::uint32_t>>;
ShortLived find_short_lived(const runtime::LinkedCode& linked, std::span<const runtime::LinkedInstruction> body);

}  // namespace plc::native
