// Makes selections of the short IFs in loops: both branches are computed, and what is assigned is chosen. A jump that
// data decides, as in a checksum, is mispredicted every other time and then costs more than both branches.
//
// A loop is copied behind the code when no other loop lies in it, nobody jumps into it, and at least one IF in it may
// be converted: its branches only compute values, few of them, and what it assigns is the same bytes as, or other bytes
// than, what it reads. Values of the branches lie in scratch memory behind the table. In: linked code, whose loops are
// marked by STRETCH instructions. Out: copies of loops behind it, for the interpreter alone, with the places of their
// instructions in the program. Compile time. Does not belong here: what instructions do.
#pragma once

#include <cstdint>
#include <vector>

#include "runtime/link.h"

namespace plc::runtime {

/// As arrange(): appends to `words`, leads the STRETCH of each loop that it copies to the copy. Behind link_loops(),
/// whose loops it leaves alone.
void link_choices(std::vector<std::uint32_t>& words, LinkedCode& code, std::uint32_t scratch);

}  // namespace plc::runtime
