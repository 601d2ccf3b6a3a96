// PidLaw: the arithmetic of a PID controller with two degrees of freedom, without ports and modes.
//
// In: process value, set-point, gains, limits and the seconds since the last step. Out: the output and its parts. The
// form is the ISA standard one of Astrom, Hagglund, "Advanced PID Control" (2006), ch. 3; anti-windup and bumpless
// transfer are those of its section 3.5. All methods are RT. Does not belong here: which mode is on (pid.h), tuning
// (relay_tuner.h).
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

namespace plc::blocks {

struct PidSignals {
  double process = 0;
  double setpoint = 0;
  double feedforward = 0;  ///< added to the output, in its unit
};

struct PidGains {
  double gain = 1;             ///< KP, output per unit of the error; not below 0
  double reset = 0;            ///< TR in seconds; 0 or less: no integral part
  double rate = 0;             ///< TD in seconds; 0 or less: no derivative part
  double filter = 10;          ///< N: the derivative is filtered with TD / N; 0 or less: it is not filtered
  double setpoint_weight = 1;  ///< B, of the proportional part
  double rate_weight = 0;      ///< C, of the derivative part
};

struct PidLimits {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
};

/// What keeps the integral part from running away while the output cannot follow it.
enum class AntiWindup : std::int16_t {
  kClamp,            ///< it grows toward a limit as far as the output does
  kBackCalculation,  ///< it is pulled back by what the limits cut off
  kActuator          ///< it is pulled back by what the actuator does not follow
};

class PidLaw {
 public:
  PidLaw() = default;
  /// `direct`: more process value asks for more output (cooling); otherwise for less (heating).
  PidLaw(bool direct, AntiWindup anti_windup) : sign_(direct ? -1 : 1), anti_windup_(anti_windup) {}

  /// Follows the slope of the process value. To be called in every cycle, whatever gives the output: the derivative
  /// part is there when the controller takes over.
  void sample(const PidSignals& signals, const PidGains& gains, double seconds) noexcept;
  /// There is no process value in this cycle: the slope is not taken across the gap.
  void skip_sample() noexcept { sampled_ = false; }

  /// The output comes from elsewhere, now `output`. The next step goes on from there.
  void stand_at(double output) noexcept {
    output_ = output;
    takes_over_ = true;
  }
  /// What pulls the integral part back, in the two anti-windups that do.
  struct Tracking {
    double seconds = 0;  ///< TT, the time constant; 0 or less: sqrt(TR * TD), or TR where TD is 0
    double actuator = 0;
  };
  /// The output, within the limits. Nothing, and nothing changed, when the sum is no finite number.
  std::optional<double> step(const PidSignals& signals, const PidGains& gains, const PidLimits& limits,
                             const Tracking& tracking, double seconds) noexcept;

  /// The error in the sense in which it is worked off: positive asks for more output.
  [[nodiscard]] double error(const PidSignals& signals) const noexcept {
    return sign_ * (signals.setpoint - signals.process);
  }
  [[nodiscard]] double proportional() const noexcept { return proportional_; }
  [[nodiscard]] double integral() const noexcept { return integral_; }
  [[nodiscard]] double derivative() const noexcept { return derivative_; }

 private:
  [[nodiscard]] double proportional_of(const PidSignals& signals, const PidGains& gains) const noexcept {
    return gains.gain * sign_ * (gains.setpoint_weight * signals.setpoint - signals.process);
  }
  [[nodiscard]] double derivative_of(const PidGains& gains) const noexcept {
    return gains.rate > 0 ? gains.gain * gains.rate * slope_ : 0;
  }

  double sign_ = 1;
  AntiWindup anti_windup_ = AntiWindup::kClamp;
  bool takes_over_ = false;
  bool stepped_ = false;  ///< gains_, sum_ and output_ are those of an earlier step
  bool sampled_ = false;  ///< last_ is the sample of the cycle before
  double last_ = 0;
  double slope_ = 0;  ///< of sign * (C * SP - PV), filtered, per second
  double proportional_ = 0;
  double integral_ = 0;
  double derivative_ = 0;
  double sum_ = 0;     ///< the last output before it was limited
  double output_ = 0;  ///< and after
  PidGains gains_{};   ///< of the last step
};

}  // namespace plc::blocks
