// The blocks of this folder.
#include "taskblocks/control/pid.h"
#include "taskblocks/set.h"

namespace plc::blocks {

PICARD_LINKED_LIBRARY(control_library, "control", "1.0.0", Pid)

}  // namespace plc::blocks
