// The time between two executions of a block, and the check that a model in discrete time runs at the pace it was made
// for.
#pragma once

#include <chrono>
#include <cmath>

#include "picard/taskblock.h"

namespace plc::blocks {

/// Measures the time from one execution to the next. RT.
class Stopwatch {
 public:
  /// Seconds since the last call; 0 in the first one.
  double lap(std::chrono::nanoseconds now) noexcept {
    const std::chrono::nanoseconds passed = started_ ? now - last_ : std::chrono::nanoseconds(0);
    last_ = now;
    started_ = true;
    return static_cast<double>(passed.count()) * 1e-9;
  }

 private:
  bool started_ = false;
  std::chrono::nanoseconds last_{};
};

/// For ready(): throws when the matrices were made for another period than that of the task. `sample_time` in seconds;
/// 0 or less: not checked. `task_period` is 0 for event and freewheeling tasks.
inline void check_sample_time(double sample_time, double task_period) {
  constexpr double kRounding = 1e-6;
  if (std::isnan(sample_time)) throw picard::Failure("TS is not a number");
  if (sample_time <= 0) return;
  if (task_period <= 0) throw picard::Failure("TS is given, but the task has no period: its executions are no samples");
  if (std::abs(task_period - sample_time) > kRounding * sample_time) {
    throw picard::Failure("TS, the sample time of the matrices, is not the period of the task");
  }
}

}  // namespace plc::blocks
