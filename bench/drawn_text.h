// Drawn programs as ST: what a rung or chain does, in the order of the drawing.
//
// In: Program. Out: a project of one file. Does not belong here: what is drawn (program.h).
#pragma once

#include <string>

#include "bench/program.h"

namespace plc::bench {

/// A coil is an assignment, one that sets or resets an IF, a chain one expression for each variable that it writes.
std::string write_st(const Program& program);

}  // namespace plc::bench
