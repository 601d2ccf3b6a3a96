// The blocks of this folder.
#include "taskblocks/filters/biquad.h"
#include "taskblocks/filters/low_pass.h"
#include "taskblocks/filters/low_pass_2.h"
#include "taskblocks/filters/moving_statistics.h"
#include "taskblocks/filters/notch.h"
#include "taskblocks/set.h"

namespace plc::blocks {

PICARD_LINKED_LIBRARY(filters_library, "filters", "1.0.0", LowPass, LowPass2, Notch, Biquad, MovingStatistics)

}  // namespace plc::blocks
