// RATE_LIMITER: follows a signal no faster than allowed.
#pragma once

#include <algorithm>
#include <cmath>

#include "picard/taskblock.h"
#include "taskblocks/elapsed.h"

namespace plc::blocks {

class RateLimiter final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{
      .name = "RATE_LIMITER",
      .group = "Signals",
      .summary = "Follows a signal no faster than a rising and a falling rate.",
      .details =
          "In each execution OUT goes towards IN, up by at most RISING times and down by at most FALLING times the "
          "time "
          "since the last one, and then stays exactly at IN. LIMITED is TRUE while OUT has not reached IN. Both rates "
          "are magnitudes and may change while it runs; at 0, below and NaN OUT does not move in that direction.\n\n"
          "The first cycle and RESET set OUT to IN at once. While IN is no finite number the outputs stay as they are; "
          "before the first one OUT is 0. Executed twice in one cycle, it does not move the second time."};

  picard::Input<double> in{this, "IN", "signal"};
  picard::Input<double> rising{this, "RISING", "fastest way up", {.unit = "1/s", .lowest = 0, .initial = "1.0"}};
  picard::Input<double> falling{this, "FALLING", "fastest way down", {.unit = "1/s", .lowest = 0, .initial = "1.0"}};
  picard::Input<bool> reset{this, "RESET", "TRUE: OUT is IN"};
  picard::Output<double> out{this, "OUT", "signal, not faster than allowed"};
  picard::Output<bool> limited{this, "LIMITED", "OUT is on its way to IN"};

  void fire() override {
    const double seconds = elapsed_.until(now());
    if (!std::isfinite(in)) return;
    if (!started_ || reset) {
      started_ = true;
      value_ = in;
    } else {
      value_ = std::clamp(in.get(), value_ - reach(falling, seconds), value_ + reach(rising, seconds));
    }
    out = value_;
    limited = value_ != in;
  }

 private:
  /// WHY the tests: an infinite rate in no time, and NaN, are no way at all.
  static double reach(double rate, double seconds) { return rate > 0 && seconds > 0 ? rate * seconds : 0; }

  Elapsed elapsed_;
  bool started_ = false;
  double value_ = 0;
};

}  // namespace plc::blocks
