// The time between two executions of a block. In: the task's clock; out: seconds. Blocks whose law has a time in it use
// this instead of the task's period, so that they are right in event and freewheeling tasks, too, and after cycles that
// were left out.
#pragma once

#include <chrono>

namespace plc::blocks {

class Elapsed {
 public:
  /// RT: seconds since the last call, 0 at the first; never below 0.
  double until(std::chrono::nanoseconds now) noexcept {
    const std::chrono::nanoseconds passed = started_ && now > last_ ? now - last_ : std::chrono::nanoseconds(0);
    started_ = true;
    last_ = now;
    return static_cast<double>(passed.count()) / 1e9;
  }

 private:
  bool started_ = false;
  std::chrono::nanoseconds last_{};
};

}  // namespace plc::blocks
