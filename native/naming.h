// Naming: how native code names variables of the table, by their distance from a register or from the code itself.
//
// Out: which of the two this processor runs faster. Does not belong here: code (assembly.h of each processor).
#pragma once

namespace plc::native {

/// Whether variables are better named from the code. Measured at the first call, which takes a millisecond; any thread.
bool names_from_code();

}  // namespace plc::native
