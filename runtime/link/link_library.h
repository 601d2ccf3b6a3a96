// Functions of the library that the interpreter has instructions for.
//
// In: an overload that is called. Out: the instruction, which takes the words of CALL_STD. Does not belong here: what
// functions do (stdlib/arithmetic.h).
#pragma once

#include <cstdint>

#include "runtime/interpreter/interpreter.h"
#include "stdlib/library.h"

namespace plc::runtime {

/// The instruction for a call with `arguments`; CALL_STD when there is no other. `known_places`: the last argument is a
/// constant from 0 to 63, for shifts and rotations.
ResolvedOp library_op(const stdlib::Overload& overload, std::uint32_t arguments, bool known_places);

}  // namespace plc::runtime
