// SIGNAL_GENERATOR: test signals.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <string_view>

#include "picard/taskblock.h"
#include "taskblocks/elapsed.h"
#include "taskblocks/signals/noise.h"

namespace plc::blocks {

class SignalGenerator final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{
      .name = "SIGNAL_GENERATOR",
      .group = "Signals",
      .summary = "Sine, square, triangle, sawtooth, chirp and noise.",
      .details =
          "`OUT = OFFSET + AMPLITUDE s(p)`, where the phase p goes from 0 to 1 in each period `1 / FREQUENCY`, and s "
          "is, "
          "by SHAPE:\n\n"
          "- `SINE`: sin(2 pi p)\n"
          "- `SQUARE`: 1 for the part DUTY of the period, then -1\n"
          "- `TRIANGLE`: from 0 up to 1, down to -1, up to 0: in phase with the sine\n"
          "- `SAWTOOTH`: from -1 up to 1, then at once to -1\n"
          "- `CHIRP`: a sine whose frequency goes from FREQUENCY to FREQUENCY_END within SWEEP, at a steady rate, then "
          "starts at FREQUENCY again without a jump of the phase\n"
          "- `NOISE`: white noise, equally likely in -1 .. 1\n"
          "- `GAUSSIAN`: white noise, normally distributed; AMPLITUDE is the standard deviation\n\n"
          "Noise is the same for the same SEED. PHASE moves all but noise ahead. All inputs may change while it runs: "
          "the phase goes on from where it is. It is counted in fractions of 2^-64 of a period and does not drift.\n\n"
          "The first cycle and RESET begin at p = 0. A FREQUENCY below 0 runs backwards; one that is not finite counts "
          "as 0, so does such a PHASE. Above half the rate of execution the samples show another frequency "
          "(aliasing)."};

  picard::Config<picard::Text<12>> shape{
      this, "SHAPE", "SINE, SQUARE, TRIANGLE, SAWTOOTH, CHIRP, NOISE or GAUSSIAN", {.initial = "'SINE'"}};
  picard::Input<double> frequency{this, "FREQUENCY", "periods in a second", {.unit = "Hz", .initial = "1.0"}};
  picard::Input<double> amplitude{this, "AMPLITUDE", "distance of the peaks from OFFSET", {.initial = "1.0"}};
  picard::Input<double> offset{this, "OFFSET", "middle of the signal"};
  picard::Input<double> phase{this, "PHASE", "how far ahead of p", {.unit = "deg"}};
  picard::Input<double> duty{
      this, "DUTY", "part of the period that SQUARE is high", {.lowest = 0, .highest = 1, .initial = "0.5"}};
  picard::Input<bool> reset{this, "RESET", "TRUE: stay at p = 0, and at the first number of the noise"};
  picard::Config<double> frequency_end{this, "FREQUENCY_END", "of CHIRP", {.unit = "Hz", .initial = "10.0"}};
  picard::Config<picard::Time> sweep{this, "SWEEP", "duration of CHIRP, above 0", {.initial = "T#10s"}};
  picard::Config<std::uint32_t> seed{this, "SEED", "of the noise", {.initial = "1"}};
  picard::Output<double> out{this, "OUT", "signal"};

  void ready() override {
    shape_ = 0;
    while (shape_ < kShapes.size() && kShapes[shape_].name != shape->view()) ++shape_;
    if (shape_ == kShapes.size()) {
      throw picard::Failure("SHAPE is none of SINE, SQUARE, TRIANGLE, SAWTOOTH, CHIRP, NOISE, GAUSSIAN");
    }
    if (sweep.get() <= picard::Time(0)) throw picard::Failure("SWEEP is not above 0");
    if (!std::isfinite(frequency_end)) throw picard::Failure("FREQUENCY_END is not finite");
    sweep_seconds_ = std::chrono::duration<double>(sweep.get()).count();
    noise_ = Noise(seed);
  }

  void fire() override {
    const double seconds = elapsed_.until(now());
    if (reset) {
      turns_ = 0;
      swept_ = 0;
      noise_ = Noise(seed);
    } else {
      const double start = std::isfinite(frequency) ? frequency.get() : 0;
      advance(kShapes[shape_].value == chirp ? sweep_turns(start, seconds) : start * seconds);
    }
    out = offset + amplitude * kShapes[shape_].value(*this);
  }

 private:
  struct Shape {
    std::string_view name;
    double (*value)(SignalGenerator&);
  };

  /// The phase, and PHASE ahead of it, in [0, 1).
  [[nodiscard]] double p() const {
    const double ahead = std::isfinite(phase) ? phase / 360 : 0;
    const double at = static_cast<double>(turns_ >> 11) * 0x1p-53 + ahead;
    const double within = at - std::floor(at);
    return within < 1 ? within : 0;  // WHY: of a tiny negative number the difference rounds to 1
  }
  /// The phase goes on by any number of turns, of which the whole ones are of no meaning.
  void advance(double turns) {
    if (!std::isfinite(turns)) return;
    const double part = turns - std::floor(turns);
    if (part < 1) turns_ += static_cast<std::uint64_t>(part * 0x1p64);
  }
  /// Turns of the chirp from swept_ on for some time: the integral of its frequency.
  double sweep_turns(double start, double seconds) {
    const auto until = [&](double time) {
      return (start + (frequency_end - start) * (time / sweep_seconds_) / 2) * time;
    };
    const double before = until(swept_);
    const double sweeps = std::floor((swept_ + seconds) / sweep_seconds_);
    swept_ = std::max(0.0, swept_ + seconds - sweeps * sweep_seconds_);
    return sweeps * until(sweep_seconds_) + until(swept_) - before;
  }

  static double sine(SignalGenerator& self) { return std::sin(2 * std::numbers::pi * self.p()); }
  static double square(SignalGenerator& self) { return self.p() < self.duty ? 1 : -1; }
  static double triangle(SignalGenerator& self) {
    const double at = self.p();
    if (at < 0.25) return 4 * at;
    return at < 0.75 ? 2 - 4 * at : 4 * at - 4;
  }
  static double sawtooth(SignalGenerator& self) { return 2 * self.p() - 1; }
  static double chirp(SignalGenerator& self) { return sine(self); }
  static double noise(SignalGenerator& self) { return 2 * self.noise_.uniform() - 1; }
  static double gaussian(SignalGenerator& self) { return self.noise_.gaussian(); }

  static constexpr std::array<Shape, 7> kShapes{{{"SINE", sine},
                                                 {"SQUARE", square},
                                                 {"TRIANGLE", triangle},
                                                 {"SAWTOOTH", sawtooth},
                                                 {"CHIRP", chirp},
                                                 {"NOISE", noise},
                                                 {"GAUSSIAN", gaussian}}};

  std::size_t shape_ = 0;
  Elapsed elapsed_;
  std::uint64_t turns_ = 0;  ///< the phase, in 2^-64 of a period: wraps as it should
  double swept_ = 0;         ///< seconds since the chirp was at FREQUENCY
  double sweep_seconds_ = 1;
  Noise noise_{0};
};

}  // namespace plc::blocks
