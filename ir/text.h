// Names of places for messages, listings and debug tables.
#pragma once

#include <string>

#include "ir/ir.h"

namespace plc::ir {

/// "Tank.Level[3]"; what a reference points at is written as the variable it was taken from.
std::string place_text(const Module& module, const Pou& pou, PlaceId place);
/// "TRUE", "-5", "'text'": a constant as a listing shows it.
std::string constant_text(const TypeTable& types, const Constant& constant);

}  // namespace plc::ir
