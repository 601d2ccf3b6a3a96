// Dead stores: results that the next instruction takes from their register, and that are overwritten before anything
// else reads them. Code does not store them.
//
// In: the resolved code of one body. Out: for each of its instructions, the operand that it need not store. Drawn
// arithmetic is full of them: every block leaves its result in a temporary of the frame that the next chain uses again.
// A result that is not overwritten is stored, even if it is never read: tables are the same after every scan, and
// whenever one ends early. Compile time, for all processors. Does not belong here: registers and code.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "native/operation.h"
#include "runtime/link/link.h"

namespace plc::native {

/// By instruction of `body`, which has no operands relative to an instance: a place may have one of these and another.
using DeadStores = std::vector<std::optional<std::uint32_t>>;
DeadStores find_dead_stores(const runtime::LinkedCode& linked, std::span<const runtime::LinkedInstruction> body);

}  // namespace plc::native
