// NaN analysis of loops: where a NaN may stay as the processor makes it, instead of the canonical one.
//
// In: a loop and its variables that are reals. Out: for each instruction whether its result may be any NaN, and which
// variables have to be made canonical before it and at each exit. Compile time. Does not belong here: ranges of
// integers (range_analysis.h).
#pragma once

#include <span>

#include "native/loop_walk.h"
#include "native/range_analysis.h"

namespace plc::native {

void find_non_canonical_reals(const Emitter& emitter, const LoopCode& code, std::span<const LoopVariable> variables,
                              LoopRanges& facts);

}  // namespace plc::native
