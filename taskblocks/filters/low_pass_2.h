// LOWPASS2: second-order Butterworth low-pass filter. Bilinear transform, prewarped: the corner is exact.
#pragma once

#include <cmath>
#include <numbers>

#include "picard/taskblock.h"
#include "taskblocks/elapsed.h"
#include "taskblocks/filters/state_variable.h"

namespace plc::blocks {

class LowPass2 final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{
      .name = "LOWPASS2",
      .group = "Filters",
      .summary = "Second-order Butterworth low-pass filter.",
      .details =
          "`H(s) = w^2 / (s^2 + sqrt(2) w s + w^2)` with `w = 2 pi CUTOFF`: flat up to CUTOFF, 40 dB a decade above. A "
          "step overshoots by 4.3 %. CUTOFF may change while it runs; OUT does not jump then.\n\n"
          "The first cycle starts at IN, as if it had always been there. The time between two executions counts, so it "
          "is right in event and freewheeling tasks, too; executed twice in one cycle, it does nothing the second "
          "time.\n\n"
          "Limits: at a CUTOFF of half the rate of execution or above there is nothing to damp, OUT is IN. At 0, below "
          "and NaN nothing passes, OUT stays as it is. While IN is no finite number OUT stays as it is; before the "
          "first one it is 0."};

  picard::Input<double> in{this, "IN", "signal"};
  picard::Input<double> cutoff{
      this, "CUTOFF", "frequency that is damped by 3 dB", {.unit = "Hz", .lowest = 0, .initial = "1.0"}};
  picard::Output<double> out{this, "OUT", "filtered signal"};

  void fire() override {
    const double seconds = elapsed_.until(now());
    if (!std::isfinite(in)) return;
    const double turns = cutoff * seconds;
    if (!started_ || turns >= 0.5) {
      started_ = true;
      filter_.settle(in);
      out = in;
    } else if (turns > 0) {
      if (turns != turns_) g_ = std::tan(std::numbers::pi * turns);
      turns_ = turns;
      out = filter_.step(in, g_, std::numbers::sqrt2).low;
    }
  }

 private:
  Elapsed elapsed_;
  bool started_ = false;
  StateVariableFilter filter_;
  double turns_ = 0;  ///< what g_ is for
  double g_ = 0;
};

}  // namespace plc::blocks
