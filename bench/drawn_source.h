// Drawn programs as sources of a workload.
//
// In: Shape. Out: Source. Does not belong here: making the program (program.h) and its texts (drawing.h, c_source.h).
#pragma once

#include "bench/program.h"
#include "bench/workload.h"

namespace plc::bench {

/// Both texts, and as variables those of the rungs and what the blocks show.
Source make_source(const Shape& shape);

}  // namespace plc::bench
