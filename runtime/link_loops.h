// Makes loop runs (loop_run.h) of counted loops whose rounds may run side by side.
//
// A loop becomes one when it counts a DINT or INT as FOR does, has no other jump, and each of its instructions computes
// a value, calls a function of the library (one of those may raise events) or moves an element of an array; when what
// it writes is either written before it is read in each round, or a sum that nobody else looks at; when each index is a
// sum of the control variable and of what the loop does not change; and when no instruction reads or writes, in a later
// round, an element that an instruction behind it writes in an earlier one. In: linked code, whose candidates are
// marked by STRETCH instructions. Out: LOOP_RUNs behind it, for the interpreter alone. Compile time. Does not belong
// here: running them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "runtime/link.h"

namespace plc::runtime {

/// Constants of the task, whose first one is at table offset `at`.
struct LinkedConstants {
  std::uint32_t at = 0;
  std::span<const std::byte> bytes;
};

/// As arrange(): appends to `words`, leads the STRETCH of each loop that becomes a run to it.
void link_loops(std::vector<std::uint32_t>& words, LinkedCode& code, const LinkedConstants& constants,
                std::uint32_t scratch);

}  // namespace plc::runtime
