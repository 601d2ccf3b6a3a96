// The blocks of this folder.
#include "taskblocks/control/kalman.h"
#include "taskblocks/control/observer.h"
#include "taskblocks/control/pid.h"
#include "taskblocks/control/state_feedback.h"
#include "taskblocks/control/state_space.h"
#include "taskblocks/set.h"

namespace plc::blocks {

PICARD_LINKED_LIBRARY(control_library, "control", "1.0.0", Pid, StateSpace, StateFeedback, Observer, Kalman)

}  // namespace plc::blocks
