// POUs that only declare what the standard library has.
//
// Editors need the interface of a block to draw it, so `plc lib --xml` gives them POUs without statements; projects
// drawn with them come back with these POUs inside. What they name is the library's own.
//
// In: Project. Out: the same without such POUs. Does not belong here: POUs of other libraries (compiler/libraries.h).
#pragma once

#include <cstddef>

#include "core/diagnostics.h"
#include "plcopen/project.h"

namespace plc::st {

/// True when the POU has not one statement, drawn element or action: its interface is all there is.
bool declares_only(const plcopen::Pou& pou);

/// Removes every function and function block that has the name of one in the library, exactly its pins (those of
/// blocks of the same types and directions), no variables of its own and not one statement or drawn element. Returns
/// how many. Anything else of a library's name is meant as it stands, and hides the library's (P4019).
std::size_t drop_library_declarations(plcopen::Project& project);

/// Warns (P4019) of functions, function blocks and data types of the project that have the name of something in the
/// library beyond the standard: RAMP, PID, SCALE. Names of the standard are told in every compilation. Of a library of
/// the user's own nothing is told: who names it means what it has.
void warn_of_hidden_names(const plcopen::Project& project, core::Diagnostics& diagnostics);

}  // namespace plc::st
