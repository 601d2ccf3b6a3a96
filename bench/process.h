// Runs a program and tells what that cost.
//
// In: a command line. Out: time, peak memory, output. Does not belong here: what the figures mean.
#pragma once

#include <string>
#include <vector>

#include "core/clock.h"

namespace plc::bench {

/// What one run of a program took.
struct Cost {
  bool ok = false;     ///< it ended by itself with exit code 0
  int exit_code = -1;  ///< -1: it did not end by itself
  double wall_ms = 0;
  double cpu_ms = 0;  ///< user and system
  double peak_mb = 0;
  std::string output;  ///< stdout
};

/// Starts `arguments[0]`, found in PATH, and waits for its end. `quiet`: what it writes to stderr is dropped.
Cost run(const std::vector<std::string>& arguments, bool quiet = false);

/// Processor time of this thread: what others on the machine take is nobody's cost.
core::TimeNs own_time_ns();

}  // namespace plc::bench
