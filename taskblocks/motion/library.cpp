// The blocks of this folder.
#include "taskblocks/motion/gear.h"
#include "taskblocks/motion/kinematics.h"
#include "taskblocks/motion/s_curve.h"
#include "taskblocks/motion/scara.h"
#include "taskblocks/motion/trapezoid.h"
#include "taskblocks/set.h"

namespace plc::blocks {

PICARD_LINKED_LIBRARY(motion_library, "motion", "1.0.0", Trapezoid, SCurve, Scara, Kinematics, Gear)

}  // namespace plc::blocks
