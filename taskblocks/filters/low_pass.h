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
          "first cycle starts at IN. In event and freewheeling tasks, which have no period, the time between two "
          "executions counts.\n\n"
          "While IN is no finite number OUT stays as it is; before the first one it is 0."};

  picard::Input<double> in{this, "IN", "signal"};
  picard::Config<double> cutoff{
      this, "CUTOFF", "frequency that is damped by 3 dB", {.unit = "Hz", .lowest = 1e-9, .initial = "1.0"}};
  picard::Output<double> out{this, "OUT", "filtered signal"};

  void ready() override {
    if (!(cutoff > 0) || !std::isfinite(cutoff)) throw picard::Failure("CUTOFF is not a frequency above 0");
  }

  void fire() override {
    const double seconds = elapsed_.until(now());
    if (!std::isfinite(in)) return;
    if (!started_) {
      started_ = true;
      value_ = in;
    } else {
      value_ += -std::expm1(-2 * std::numbers::pi * cutoff * seconds) * (in - value_);
    }
    out = value_;
  }

 private:
  Elapsed elapsed_;
  bool started_ = false;
  double value_ = 0;
};

}  // namespace plc::blocks
