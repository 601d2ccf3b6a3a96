// LOWPASS: first-order low-pass filter, exact for inputs that change in steps at the cycle.
#pragma once

#include <cmath>
#include <numbers>

#include "picard/taskblock.h"
#include "taskblocks/elapsed.h"

namespace plc::blocks {

class LowPass final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{
      .name = "LOWPASS",
      .group = "Filters",
      .summary = "First-order low-pass filter.",
      .details =
          "OUT follows IN with the time constant 1 / (2 pi CUTOFF): after one of them 63 % of a step are there. The "
          "first cycle starts at IN. The time between two executions counts, so it is right in event and freewheeling "
          "tasks, too. CUTOFF may change while it runs; OUT does not jump then.\n\n"
          "Limits: the higher CUTOFF is, the closer OUT is to IN. At 0, below and NaN nothing passes, OUT stays as it "
          "is. While IN is no finite number OUT stays as it is; before the first one it is 0."};

  picard::Input<double> in{this, "IN", "signal"};
  picard::Input<double> cutoff{
      this, "CUTOFF", "frequency that is damped by 3 dB", {.unit = "Hz", .lowest = 0, .initial = "1.0"}};
  picard::Output<double> out{this, "OUT", "filtered signal"};

  void fire() override {
    const double seconds = elapsed_.until(now());
    if (!std::isfinite(in)) return;
    const double turns = cutoff * seconds;
    if (!started_) {
      started_ = true;
      value_ = in;
    } else if (turns > 0) {
      if (turns != turns_) gain_ = -std::expm1(-2 * std::numbers::pi * turns);
      turns_ = turns;
      value_ += gain_ * (in - value_);
    }
    out = value_;
  }

 private:
  Elapsed elapsed_;
  bool started_ = false;
  double value_ = 0;
  double turns_ = 0;  ///< what gain_ is for
  double gain_ = 0;
};

}  // namespace plc::blocks
