#include "taskblocks/control/pid_law.h"

#include <algorithm>
#include <cmath>

namespace plc::blocks {

void PidLaw::sample(const PidSignals& signals, const PidGains& gains, double seconds) noexcept {
  const double value = sign_ * (gains.rate_weight * signals.setpoint - signals.process);
  if (!std::isfinite(value)) {
    sampled_ = false;
    return;
  }
  if (sampled_ && seconds <= 0) return;  // executed twice in a cycle: no second sample
  if (sampled_) {
    // Exact for values that change in straight lines from sample to sample, and stable for any TD / N.
    const double constant = gains.filter > 0 ? std::max(gains.rate, 0.0) / gains.filter : 0;
    const double share = constant > 0 ? -std::expm1(-seconds / constant) : 1;
    const double slope = slope_ + share * ((value - last_) / seconds - slope_);
    slope_ = std::isfinite(slope) ? slope : 0;
  }
  last_ = value;
  sampled_ = true;
}

std::optional<double> PidLaw::step(const PidSignals& signals, const PidGains& gains, const PidLimits& limits,
                                   const Tracking& tracking, double seconds) noexcept {
  const double proportional = proportional_of(signals, gains);
  const double derivative = derivative_of(gains);
  const double direct = proportional + derivative + signals.feedforward;
  double integral = integral_;
  if (!(gains.reset > 0)) {
    integral = 0;
  } else if (takes_over_) {
    integral = output_ - direct;
  } else if (stepped_) {
    // What a change of the gains does to the other parts, the integral part takes back: they can be tuned while
    // running.
    integral += proportional_of(signals, gains_) + derivative_of(gains_) - proportional - derivative;
    const double growth = gains.gain * error(signals) * seconds / gains.reset;
    if (anti_windup_ == AntiWindup::kClamp) {
      const double before = direct + integral;
      integral += growth > 0 ? std::min(growth, std::max(limits.high - before, 0.0))
                             : std::max(growth, std::min(limits.low - before, 0.0));
    } else {
      const double chosen = tracking.seconds > 0 ? tracking.seconds
                            : gains.rate > 0     ? std::sqrt(gains.reset * gains.rate)
                                                 : gains.reset;
      // The difference of the last step: what an actuator says in this cycle it did with the output of the last one.
      const double applied = anti_windup_ == AntiWindup::kActuator ? tracking.actuator : output_;
      integral += growth - std::expm1(-seconds / chosen) * (applied - sum_);
    }
  }
  const double sum = direct + integral;
  if (!std::isfinite(sum)) return {};
  proportional_ = proportional;
  integral_ = integral;
  derivative_ = derivative;
  gains_ = gains;
  sum_ = sum;
  output_ = std::clamp(sum, limits.low, limits.high);
  takes_over_ = false;
  stepped_ = true;
  return output_;
}

}  // namespace plc::blocks
