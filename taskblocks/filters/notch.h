// NOTCH: takes one frequency out of a signal. Bilinear transform; centre and width are exact.
#pragma once

#include <cmath>
#include <numbers>

#include "picard/taskblock.h"
#include "taskblocks/elapsed.h"
#include "taskblocks/filters/state_variable.h"

namespace plc::blocks {

class Notch final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{
      .name = "NOTCH",
      .group = "Filters",
      .summary = "Takes one frequency out of a signal.",
      .details =
          "`H(s) = (s^2 + w^2) / (s^2 + w s / Q + w^2)` with `w = 2 pi FREQUENCY`: nothing of FREQUENCY is left once "
          "it "
          "has settled, some 1 / WIDTH seconds after the start; constant and fast signals pass. WIDTH is the distance "
          "of the two frequencies that are damped by 3 dB, Q is FREQUENCY / WIDTH. For hum of the mains or the "
          "resonance of a mechanical part. FREQUENCY and WIDTH may change while it runs.\n\n"
          "The first cycle starts at IN, as if it had always been there. The time between two executions counts, so it "
          "is right in event and freewheeling tasks, too; executed twice in one cycle, it does nothing the second "
          "time.\n\n"
          "Limits: FREQUENCY and WIDTH must both be above 0 and below half the rate of execution, otherwise OUT is IN. "
          "While IN is no finite number OUT stays as it is; before the first one it is 0."};

  picard::Input<double> in{this, "IN", "signal"};
  picard::Input<double> frequency{
      this, "FREQUENCY", "frequency that is taken out", {.unit = "Hz", .lowest = 0, .initial = "50.0"}};
  picard::Input<double> width{this,
                              "WIDTH",
                              "distance of the two frequencies that are damped by 3 dB",
                              {.unit = "Hz", .lowest = 0, .initial = "5.0"}};
  picard::Output<double> out{this, "OUT", "signal without FREQUENCY"};

  void fire() override {
    const double seconds = elapsed_.until(now());
    if (!std::isfinite(in)) return;
    if (!started_) {
      restart();
    } else if (seconds > 0) {
      const double turns = frequency * seconds;
      const double turns_wide = width * seconds;
      if (turns > 0 && turns < 0.5 && turns_wide > 0 && turns_wide < 0.5) {
        if (turns != turns_ || turns_wide != turns_wide_) tune(turns, turns_wide);
        out = filter_.step(in, g_, k_).notch;
      } else {
        restart();
      }
    }
  }

 private:
  void restart() {
    started_ = true;
    filter_.settle(in);
    out = in;
  }

  void tune(double turns, double turns_wide) {
    turns_ = turns;
    turns_wide_ = turns_wide;
    g_ = std::tan(std::numbers::pi * turns);
    // WHY: the transform maps the edges f1, f2 to x = tan(pi f dt) with x2 - x1 = k g and x1 x2 = g^2; solved for k by
    // the tangent of a difference.
    k_ = std::tan(std::numbers::pi * turns_wide) * (1 + g_ * g_) / g_;
  }

  Elapsed elapsed_;
  bool started_ = false;
  StateVariableFilter filter_;
  double turns_ = 0, turns_wide_ = 0;  ///< what g_ and k_ are for
  double g_ = 0, k_ = 0;
};

}  // namespace plc::blocks
