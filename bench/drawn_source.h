// Drawn programs as sources of a workload.
//
// In: Shape. Out: Source. Does not belong here: making the program (program.h) and its texts (drawing.h, drawn_text.h,
// c_source.h).
#pragma once

#include <cstdint>

#include "bench/program.h"
#include "bench/workload.h"

namespace plc::bench {

/// Language of the project.
enum class Text : std::uint8_t { kXml, kSt };

/// Project and C, and as variables those of the rungs and what the blocks show.
Source make_source(const Shape& shape, Text text);

}  // namespace plc::bench
