#include "taskblocks/control/relay_tuner.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace plc::blocks {
namespace {

/// Two cycles in a row are the same oscillation when period and amplitude differ by less than this share.
constexpr double kRepeats = 0.02;
/// Up and down may differ by this share of the period: the describing function is that of a symmetric relay.
constexpr double kSymmetric = 0.05;

}  // namespace

void RelayTuner::start(const Settings& settings) noexcept {
  settings_ = settings;
  const bool fits = settings.step > 0 && settings.high - settings.low >= 2 * settings.step;
  if (!fits) {
    state_ = State::kNoRoom;
    return;
  }
  state_ = State::kRunning;
  settings_.hysteresis = std::max(settings.hysteresis, 0.0);
  settings_.bias = std::clamp(settings.bias, settings.low + settings.step, settings.high - settings.step);
  passed_ = 0;
  cycle_time_ = 0;
  in_cycle_ = false;
  up_ = false;
  last_ = {};
}

double RelayTuner::step(double process, double seconds) noexcept {
  if (seconds <= 0) return output();  // executed twice in a cycle: no second sample
  passed_ += seconds;
  cycle_time_ += seconds;
  lowest_ = std::min(lowest_, process);
  highest_ = std::max(highest_, process);
  const double error = settings_.direct ? process - settings_.setpoint : settings_.setpoint - process;
  if (up_ && error < -settings_.hysteresis) {
    up_ = false;
    up_time_ = cycle_time_;
  } else if (!up_ && error > settings_.hysteresis) {
    up_ = true;
    if (in_cycle_) end_cycle();
    begin_cycle(process);
  }
  if (running() && passed_ >= settings_.timeout) state_ = State::kNoOscillation;
  return output();
}

void RelayTuner::begin_cycle(double process) noexcept {
  in_cycle_ = true;
  cycle_time_ = 0;
  lowest_ = process;
  highest_ = process;
}

void RelayTuner::end_cycle() noexcept {
  const Cycle cycle{.period = cycle_time_, .amplitude = (highest_ - lowest_) / 2};
  const double asymmetry = (2 * up_time_ - cycle.period) / cycle.period;
  const auto near = [](double a, double b) { return std::abs(a - b) <= kRepeats * a; };
  const double amplitude = (cycle.amplitude + last_.amplitude) / 2;
  if (near(cycle.period, last_.period) && near(cycle.amplitude, last_.amplitude) && std::abs(asymmetry) <= kSymmetric &&
      amplitude > settings_.hysteresis) {
    ultimate_period_ = (cycle.period + last_.period) / 2;
    // -1 / N(a) of a relay with hysteresis h is -pi / (4 d) * (sqrt(a^2 - h^2) + j h): its real part is -1 / gain.
    const double real = std::sqrt(amplitude * amplitude - settings_.hysteresis * settings_.hysteresis);
    ultimate_gain_ = 4 * settings_.step / (std::numbers::pi * real);
    state_ = State::kDone;
  }
  // The mean of the output over a cycle is what the process needs to stay at the set-point. Swinging about it makes
  // both halves equally long. The first cycle says nothing of that yet: it comes out of rest.
  if (last_.period > 0) {
    settings_.bias = std::clamp(settings_.bias + settings_.step * asymmetry, settings_.low + settings_.step,
                                settings_.high - settings_.step);
  }
  last_ = cycle;
}

TunedGains tuned_gains(TuningRule rule, double ultimate_gain, double ultimate_period) noexcept {
  // Ziegler, Nichols, Trans. ASME 64 (1942); Tyreus, Luyben, Ind. Eng. Chem. Res. 31 (1992); McCormack, Godfrey, IEEE
  // Trans. Control Systems Technology 6 (1998).
  static constexpr std::array<TunedGains, kTuningRules> kShares{{{0.6, 0.5, 0.125},
                                                                 {0.45, 1 / 1.2, 0},
                                                                 {0.5, 0, 0},
                                                                 {1 / 2.2, 2.2, 1 / 6.3},
                                                                 {1 / 3.2, 2.2, 0},
                                                                 {0.33, 0.5, 0.33},
                                                                 {0.2, 0.5, 0.33}}};
  const TunedGains& shares = kShares[static_cast<std::size_t>(rule)];
  return {shares.gain * ultimate_gain, shares.reset * ultimate_period, shares.rate * ultimate_period};
}

}  // namespace plc::blocks
