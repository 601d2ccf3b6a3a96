// GEAR: an axis that follows another one with a ratio, as if by gear wheels with a clutch.
#pragma once

#include <algorithm>
#include <cmath>

#include "picard/taskblock.h"

namespace plc::blocks {

class Gear final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{
      .name = "GEAR",
      .group = "Motion",
      .summary = "Follows a master axis with a ratio, with a clutch that slips while it closes.",
      .details =
          "dSLAVE = RATIO dMASTER. With ENGAGE, RATIO goes to NUMERATOR / DENOMINATOR with SLEW per second, without "
          "it to 0: so the speed of SLAVE has no step. Once RATIO is there (ENGAGED), SLAVE is a fixed place plus "
          "NUMERATOR / DENOMINATOR times MASTER: roundings do not add up, however long it runs. A ratio that is "
          "changed meanwhile is reached in the same way.\n\n"
          "MODULO is what a rotary MASTER counts to before it begins again; it may turn by less than half of that in "
          "a cycle. 0: it does not begin again. The first cycle gives START and takes MASTER as it is.\n\n"
          "A MASTER that is no number, a DENOMINATOR of 0, and a ratio or SLEW that is no number or a SLEW below 0 "
          "set ERROR: SLAVE stays, RATIO is 0, and what MASTER does meanwhile is not made up for."};

  picard::Input<double> master{this, "MASTER", "position of the leading axis", {.unit = "u"}};
  picard::Input<double> numerator{this, "NUMERATOR", "of the ratio", {.initial = "1.0"}};
  picard::Input<double> denominator{this, "DENOMINATOR", "of the ratio", {.initial = "1.0"}};
  picard::Input<bool> engage{this, "ENGAGE", "close the clutch"};
  picard::Input<double> slew{this, "SLEW", "how fast RATIO changes", {.unit = "1/s", .lowest = 0, .initial = "1.0"}};
  picard::Config<double> modulo{this, "MODULO", "range of a rotary MASTER, or 0", {.unit = "u", .lowest = 0}};
  picard::Config<double> start{this, "START", "SLAVE at the start", {.unit = "u"}};
  picard::Output<double> slave{this, "SLAVE", "set point of the axis that follows", {.unit = "u"}};
  picard::Output<double> ratio{this, "RATIO", "at this moment"};
  picard::Output<bool> engaged{this, "ENGAGED", "RATIO is the one that is asked for"};
  picard::Output<bool> error{this, "ERROR", "an input makes no sense"};

  void ready() override {
    if (!std::isfinite(start)) throw picard::Failure("GEAR: START is not a finite number");
    if (std::isinf(modulo)) throw picard::Failure("GEAR: MODULO is not a finite number");
    slave = start;
  }

  void fire() override {
    const double seconds = static_cast<double>((now() - last_).count()) * 1e-9;
    last_ = now();
    const double asked = engage ? numerator / denominator : 0;
    error = !(std::isfinite(master) && std::isfinite(asked) && std::isfinite(slew) && slew >= 0);
    if (error) {
      ratio = 0;
      engaged = false;
      known_ = false;
      return;
    }
    if (modulo > 0 && known_) turns_ += std::round((raw_ - master) / modulo);
    raw_ = master;
    const double place = master + turns_ * modulo;
    const double before = ratio;
    if (known_) ratio = before + std::clamp(asked - before, -slew * seconds, slew * seconds);
    if (!known_ || before != asked) {
      if (known_) slave = slave + (before + ratio) / 2 * (place - place_);
      slave_from_ = slave;
      master_from_ = place;
    } else {
      slave = slave_from_ + asked * (place - master_from_);
    }
    place_ = place;
    known_ = true;
    engaged = engage && ratio == asked;
  }

 private:
  std::chrono::nanoseconds last_{};
  bool known_ = false;  ///< MASTER of the cycle before was a number
  double raw_ = 0;      ///< MASTER of the cycle before
  double turns_ = 0;    ///< of a rotary one
  double place_ = 0;    ///< MASTER of the cycle before, with its turns
  double slave_from_ = 0;
  double master_from_ = 0;
};

}  // namespace plc::blocks
