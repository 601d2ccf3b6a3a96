// The blocks of the CNC example as a library that plc.toml can name.
#include "gcode_block.h"
#include "interpolator_block.h"
#include "path_plot_block.h"
#include "picard/taskblock.h"
#include "servo_block.h"

PICARD_LIBRARY("cnc", "1.0.0", cnc::GcodeBlock, cnc::InterpolatorBlock, cnc::ServoBlock, cnc::PathPlotBlock)
