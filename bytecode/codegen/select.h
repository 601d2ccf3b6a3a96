// Which opcode implements a standard function for given types: the `function` column of opcodes.def, read backwards.
#pragma once

#include <optional>

#include "bytecode/opcode.h"
#include "stdlib/library.h"

namespace plc::bytecode {

/// The opcode that computes the two-argument form of `overload`, if there is one.
std::optional<Opcode> opcode_for(const stdlib::Overload& overload);
/// The opcode that copies a scalar or string of this representation.
Opcode move_for(core::Rep rep);
/// The RANGE opcode of an integer representation.
Opcode range_for(core::Rep rep);

}  // namespace plc::bytecode
