// The blocks of this folder.
#include "taskblocks/filters/low_pass.h"
#include "taskblocks/set.h"

namespace plc::blocks {

PICARD_LINKED_LIBRARY(filters_library, "filters", "1.0.0", LowPass)

}  // namespace plc::blocks
