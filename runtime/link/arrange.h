// Arranges straight code for the interpreter: brings instructions of one kind side by side, so that a loop over their
// operands (value_runs.h, bool_run.h) runs them instead of one mispredicted jump each.
//
// A stretch is code that nobody jumps into or out of and whose instructions do nothing but compute. Networks of a
// drawing are mostly independent, so its instructions may run in many orders; any order in which each one reads what it
// read before is as good, and nobody sees a table inside a scan. Values that are overwritten later in the stretch move
// to scratch memory behind the table, so that reuse of a temporary does not put networks in line.
//
// In: linked code, whose stretches are marked by STRETCH instructions. Out: the same code, arranged copies behind it,
// STRETCH instructions that lead to them. Compilers (native/) read the code as it was. Compile time. Does not belong
// here: what instructions do.
#pragma once

#include "runtime/link/link.h"

namespace plc::runtime {

/// `words`: the code so far, aligned as in LinkedCode. Appends to it and changes the operands of STRETCH instructions.
/// `scratch`: table offset of kScratchBytes bytes that belong to nobody.
void arrange(std::vector<std::uint32_t>& words, LinkedCode& code, std::uint32_t scratch);

}  // namespace plc::runtime
