// The check that a model in discrete time runs at the pace it was made for.
#pragma once

#include <cmath>

#include "picard/taskblock.h"

namespace plc::blocks {

/// For ready(): throws when the matrices were made for another period than that of the task. `sample_time` in seconds;
/// 0 or less: not checked. `task_period` is 0 for event and freewheeling tasks.
inline void check_sample_time(double sample_time, double task_period) {
  constexpr double kRounding = 1e-6;
  if (sample_time <= 0) return;
  if (task_period <= 0) throw picard::Failure("TS is given, but the task has no period: its executions are no samples");
  if (std::abs(task_period - sample_time) > kRounding * sample_time) {
    throw picard::Failure("TS, the sample time of the matrices, is not the period of the task");
  }
}

}  // namespace plc::blocks
