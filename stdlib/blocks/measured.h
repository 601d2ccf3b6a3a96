// What the blocks for measured values share: numbers that are none, the time between executions, the slope of samples.
//
// In: values and the clock of the cycle. Out: finite numbers only, unless others are written into the memory of an
// instance: then they are the same on every processor, too. The rules for all of them: an execution with a NaN
// or an infinity at an input that counts leaves outputs and memory as they are; results are computed as LREAL and held
// within the range of REAL. Pins called CYCLE exist for drawings made elsewhere: time is
// measured, so that jitter and a wrong constant do no harm. RT. Does not belong here: blocks.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "stdlib/arithmetic.h"
#include "stdlib/row.h"

namespace plc::stdlib::fb {

inline constexpr std::string_view kAnnexF = "not in the third edition; IEC 61131-3:2003, annex F";
inline constexpr std::string_view kCycleSummary = "not used: the time between executions is measured";

/// The largest finite REAL.
inline constexpr double kMostReal = std::numeric_limits<float>::max();

/// No value is NaN or infinite.
template <class... V>
bool all_finite(V... values) noexcept {
  return (std::isfinite(values) && ...);
}
/// `v` held within the finite values of REAL; NaN, which only memory written from outside makes, is the canonical one.
inline double within_real(double v) noexcept { return canonical(std::clamp(v, -kMostReal, kMostReal)); }
inline float to_real(double v) noexcept { return static_cast<float>(within_real(v)); }

inline double to_seconds(std::int64_t ns) noexcept { return static_cast<double>(ns) / 1e9; }

/// Measures the time from one execution to the next.
struct Stopwatch {
  std::int64_t last = 0;
  std::uint8_t started = 0;

  /// Seconds since the last call; 0 in the first one, and when the clock is before it.
  double lap(core::TimeNs now) noexcept {
    const std::int64_t passed = started != 0 ? wrap_sub(now, last) : 0;
    last = now;
    started = 1;
    return to_seconds(std::max<std::int64_t>(passed, 0));
  }
};

/// Slope of the line through the last four samples: least squares over the times at which they were taken. For equal
/// cycles that is the formula of annex F, (3 x0 + x1 - x2 - 3 x3) / (10 CYCLE): a derivative and a filter in one.
struct Slope {
  static constexpr unsigned kKept = 3;

  std::int64_t at[kKept] = {};  ///< newest first
  float x[kKept] = {};
  std::uint8_t count = 0;
  double value = 0;  ///< per second; 0 until there are two samples

  void forget() noexcept {
    count = 0;
    value = 0;
  }
  /// Takes a sample. A second one at the same instant is none; a clock that went back begins anew.
  double take(float sample, core::TimeNs now) noexcept {
    // The memory of an instance can be written from outside, so the samples are those that there is room for.
    count = std::min<std::uint8_t>(count, kKept);
    if (count != 0 && now == at[0]) return value;
    if (count != 0 && now < at[0]) forget();
    if (count != 0) value = through(sample, now);
    if (!all_finite(value)) forget();
    for (unsigned i = kKept - 1; i > 0; --i) {
      at[i] = at[i - 1];
      x[i] = x[i - 1];
    }
    at[0] = now;
    x[0] = sample;
    if (count < kKept) ++count;
    return value;
  }

 private:
  [[nodiscard]] double through(float sample, core::TimeNs now) const noexcept {
    double mean_t = 0, mean_x = sample;
    for (unsigned i = 0; i < count; ++i) {
      mean_t += to_seconds(wrap_sub(at[i], now));
      mean_x += static_cast<double>(x[i]);
    }
    mean_t /= count + 1;
    mean_x /= count + 1;
    double product = -mean_t * (static_cast<double>(sample) - mean_x), square = mean_t * mean_t;
    for (unsigned i = 0; i < count; ++i) {
      const double t = to_seconds(wrap_sub(at[i], now)) - mean_t;
      product += t * (static_cast<double>(x[i]) - mean_x);
      square += t * t;
    }
    return product / square;
  }
};

}  // namespace plc::stdlib::fb
