// Taskblocks of the benchmark: ONE_EMPTY and EIGHT_EMPTY do nothing, so that all that is measured is what is around
// them; ONE_WORKING and EIGHT_WORKING pass their inputs on, plus 1.
//
// In: nothing. Out: a registry of them, and the objects that were made. Does not belong here: programs that use them.
#pragma once

#include <vector>

#include "taskblocks/registry.h"

namespace plc::bench {

const taskblocks::Registry& bench_taskblocks();

/// All objects that were made since it was emptied, in the order in which a program executes them. One thread.
std::vector<void*>& made_taskblocks();

}  // namespace plc::bench
