// Function blocks with generic constants (CODESYS): FB<10> of a block with VAR_GENERIC CONSTANT becomes a block of its
// own, with this value for the constant.
//
// In: a Project as it was read, libraries joined. Out: the same with one more function block for each set of values.
// Does not belong here: functions made for bounds of arrays (ir/generic.h), types of variables.
#pragma once

#include "core/diagnostics.h"
#include "plcopen/project.h"

namespace plc::st {

/// Blocks made so in one project.
inline constexpr std::size_t kMaxGenericBlocks = 4096;

/// Makes the blocks that types of variables name, nested ones included. Reports P4530 for values that no constant
/// takes. The block that others are made from is compiled only when something uses it by its plain name, with the
/// values of its declaration.
void make_generic_blocks(plcopen::Project& project, core::Diagnostics& diagnostics);

}  // namespace plc::st
