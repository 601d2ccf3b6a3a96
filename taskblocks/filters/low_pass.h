// LOWPASS: first-order low-pass filter, exact for inputs that change in steps at the cycle.
#pragma once

#include <cmath>
#include <numbers>

#include "picard/taskblock.h"

namespace plc::blocks {

class LowPass final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{.name = "LOWPASS",
                                     .group = "Filters",
                                     .summary = "First-order low-pass filter.",
                                     .details =
                                         "OUT follows IN with the time constant 1 / (2 pi CUTOFF): after one of them "
                                         "63 % of a step are there. The first "
                                         "cycle starts at IN. In event and freewheeling tasks, which have no period, "
                                         "the time between two executions counts."};

  picard::Input<double> in{this, "IN", "signal"};
  picard::Config<double> cutoff{
      this, "CUTOFF", "frequency that is damped by 3 dB", {.unit = "Hz", .lowest = 1e-9, .initial = "1.0"}};
  picard::Output<double> out{this, "OUT", "filtered signal"};

  void fire() override {
    const std::chrono::nanoseconds at = now();
    if (!started_) {
      started_ = true;
      out = in;
    } else {
      const double seconds = static_cast<double>((at - last_).count()) * 1e-9;
      out = out + -std::expm1(-2 * std::numbers::pi * cutoff * seconds) * (in - out);
    }
    last_ = at;
  }

 private:
  bool started_ = false;
  std::chrono::nanoseconds last_{};
};

}  // namespace plc::blocks
