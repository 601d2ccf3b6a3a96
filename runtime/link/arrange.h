// Arranges straight code for the interpreter: brings instructions of one kind side by side, so that a loop over their
// operands (value_runs.h, bool_run.h) runs them instead of one mispredicted jump each.
//
// It works on basic blocks of instructions without side effects. Networks of a drawing are mostly independent, so their
// instructions may run in any order that keeps data dependences; the table is not looked at inside a scan. Values that
// are overwritten later in the block are renamed to scratch memory after the table, so that the reuse of a temporary
// does not make networks depend on each other.
//
// In: linked code, whose basic blocks are marked by BLOCK_START instructions. Out: the same code, arranged copies
// after it, BLOCK_START instructions that lead to them. Compilers (native/) read the code as it was. Compile time.
// Does not belong here: what instructions do.
#pragma once

#include "runtime/link/link.h"

namespace plc::runtime {

/// `words`: the code so far, aligned as in LinkedCode. Appends to it and changes the operands of BLOCK_START
/// instructions. `scratch`: table offset of kScratchBytes bytes that are free.
void arrange(std::vector<std::uint32_t>& words, LinkedCode& code, std::uint32_t scratch);

}  // namespace plc::runtime
