// What may have been meant: names of functions and blocks, operators of other languages.
//
// In: what was written. Out: help lines, empty when nothing is near. Does not belong here: names of one table
// (core/guess.h).
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "ir/ir.h"

namespace plc::st {

/// For a function that there is not: one of the project or of the library, conversions by the types in their name.
std::string function_meant(const ir::Module& module, const ir::Pou& caller, std::string_view name);
/// For a drawn block that there is not: functions and function blocks.
std::string block_meant(const ir::Module& module, std::string_view name);
/// For the operator at `position` of `text` that ST does not have ("==", "!=", "&&"), or that does not belong there
/// (":=" in a condition): how ST writes it.
std::string operator_meant(std::string_view text, std::size_t position);

}  // namespace plc::st
