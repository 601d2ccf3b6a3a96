// The blocks of the CNC example as a library that plc.toml can name.
#include "examples/cnc/blocks/gcode_block.h"
#include "examples/cnc/blocks/interpolator_block.h"
#include "examples/cnc/blocks/servo_block.h"
#include "picard/taskblock.h"

PICARD_LIBRARY("cnc", "1.0.0", cnc::GcodeBlock, cnc::InterpolatorBlock, cnc::ServoBlock)
