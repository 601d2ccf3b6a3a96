// Names of places for messages, listings and debug tables.
#pragma once

#include <string>

#include "ir/ir.h"

namespace plc::ir {

/// "Tank.Level[3]"; what a reference points at is written as the variable it was taken from. With `value_ids` computed
/// indices are values of the listing ("[%12]").
std::string place_text(const Module& module, const Pou& pou, PlaceId place, bool value_ids = false);
/// "TRUE", "-5", "'text'": a constant as a listing shows it.
std::string constant_text(const TypeTable& types, const Constant& constant);

}  // namespace plc::ir
