// RelayTuner: finds out where a loop would oscillate, by letting a relay take the controller's place.
//
// The method of Astrom, Hagglund, "Automatic tuning of simple regulators with specifications on phase and amplitude
// margins", Automatica 20 (1984): the output jumps by +-step about its bias whenever the process value crosses the
// set-point, and the process answers with an oscillation at nearly its ultimate period. The relay's describing function
// gives the ultimate gain.
//
// In: process value and seconds in every cycle. Out: the relay's output; at the end ultimate gain and period, and gains
// after a rule. RT. Does not belong here: the controller that stands aside meanwhile (pid.h).
#pragma once

#include <cstdint>

namespace plc::blocks {

class RelayTuner {
 public:
  /// As the pin TUNE_STATE says it.
  enum class State : std::int16_t {
    kIdle,
    kRunning,
    kDone,
    kStopped,        ///< by the operator
    kNoOscillation,  ///< none that repeats itself within the time given
    kNoRoom,         ///< the relay's step does not fit between the limits, or is no step
    kBadInput        ///< a value was NaN or infinite
  };

  struct Settings {
    double setpoint = 0;
    double bias = 0;        ///< output about which the relay swings; moved where that does not fit between the limits
    double step = 0;        ///< of the relay to each side, above 0
    double hysteresis = 0;  ///< the process value must be this far beyond the set-point: above its noise
    double low = 0;         ///< limits of the output
    double high = 0;
    double timeout = 0;   ///< seconds
    bool direct = false;  ///< more process value asks for more output
  };

  void start(const Settings& settings) noexcept;
  /// Ends a tuning that is running, and says why.
  void stop(State why) noexcept {
    if (running()) state_ = why;
  }
  /// The output of this cycle while it runs; what it is last is not to be applied.
  double step(double process, double seconds) noexcept;

  [[nodiscard]] bool running() const noexcept { return state_ == State::kRunning; }
  [[nodiscard]] State state() const noexcept { return state_; }
  /// The output that holds the process at the set-point on average.
  [[nodiscard]] double bias() const noexcept { return settings_.bias; }
  /// Output per unit of the process value; 0 before the first success.
  [[nodiscard]] double ultimate_gain() const noexcept { return ultimate_gain_; }
  /// Seconds.
  [[nodiscard]] double ultimate_period() const noexcept { return ultimate_period_; }

 private:
  struct Cycle {
    double period = 0;
    double amplitude = 0;
  };

  [[nodiscard]] double output() const noexcept {
    return up_ ? settings_.bias + settings_.step : settings_.bias - settings_.step;
  }
  void begin_cycle(double process) noexcept;
  void end_cycle() noexcept;

  Settings settings_{};
  State state_ = State::kIdle;
  bool up_ = false;
  bool in_cycle_ = false;  ///< false before the first switch upward
  double passed_ = 0;      ///< seconds since the start
  double cycle_time_ = 0;  ///< seconds since the last switch upward
  double up_time_ = 0;     ///< of these, with the output up
  double lowest_ = 0;      ///< process value in this cycle
  double highest_ = 0;
  Cycle last_{};
  double ultimate_gain_ = 0;
  double ultimate_period_ = 0;
};

/// Rows of the table of tuning rules, as the pin TUNE_RULE says it.
enum class TuningRule : std::int16_t {
  kZieglerNicholsPid,
  kZieglerNicholsPi,
  kZieglerNicholsP,
  kTyreusLuybenPid,
  kTyreusLuybenPi,
  kSomeOvershoot,
  kNoOvershoot
};
inline constexpr std::int16_t kTuningRules = 7;

struct TunedGains {
  double gain = 0;
  double reset = 0;  ///< seconds; 0: no integral part
  double rate = 0;   ///< seconds; 0: no derivative part
};
TunedGains tuned_gains(TuningRule rule, double ultimate_gain, double ultimate_period) noexcept;

}  // namespace plc::blocks
