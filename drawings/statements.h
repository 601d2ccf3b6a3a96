// Where the statements of a text are.
//
// In: a body in ST or IL. Out: their places in the file. Does not belong here: what they do.
#pragma once

#include <vector>

#include "bytecode/drawings.h"
#include "core/diagnostics.h"
#include "plcopen/project.h"

namespace plc::drawings {

/// Statements of ST, an IF before what is in it, ELSIF and CASE branches by their statements alone; instructions of IL.
/// `places` knows the file of the body. What cannot be read is left out.
std::vector<bytecode::DrawnStatement> statements_of(const plcopen::Body& body, const core::Diagnostics& places);

}  // namespace plc::drawings
