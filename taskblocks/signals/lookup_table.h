// LOOKUP_TABLE: a curve through given points.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "picard/taskblock.h"

namespace plc::blocks {

class LookupTable final : public picard::Taskblock {
 public:
  static constexpr std::size_t kPoints = 64;
  static constexpr picard::Info info{
      .name = "LOOKUP_TABLE",
      .group = "Signals",
      .summary = "Curve through up to 64 points, straight lines between them.",
      .details =
          "`OUT = Y[i] + (Y[i+1] - Y[i]) (IN - X[i]) / (X[i+1] - X[i])` for IN between X[i] and X[i+1]; at a point OUT "
          "is "
          "exactly its Y. The first POINTS elements of X and Y count. X must rise from each to the next, and both must "
          "be "
          "finite, otherwise the program does not start. For curves of sensors, valves and pumps.\n\n"
          "Outside of the curve OUTSIDE is TRUE and OUT the Y of the nearest end, or, with EXTRAPOLATE, the first or "
          "last line goes on. An infinite IN gives the Y of that end in both cases. While IN is NaN the outputs stay "
          "as "
          "they are."};

  picard::Input<double> in{this, "IN", "place on the curve"};
  picard::Config<std::array<double, kPoints>> x{this, "X", "places of the points, rising"};
  picard::Config<std::array<double, kPoints>> y{this, "Y", "values of the points"};
  picard::Config<std::int32_t> points{
      this, "POINTS", "points that count", {.lowest = 2, .highest = kPoints, .initial = "2"}};
  picard::Config<bool> extrapolate{this, "EXTRAPOLATE", "TRUE: the outer lines go on; FALSE: the ends are held"};
  picard::Output<double> out{this, "OUT", "value of the curve at IN"};
  picard::Output<bool> outside{this, "OUTSIDE", "IN is not between the first and the last point"};

  void ready() override {
    count_ = static_cast<std::size_t>(points.get());
    for (std::size_t i = 0; i < count_; ++i) {
      if (!std::isfinite(x[i]) || !std::isfinite(y[i])) throw picard::Failure("X or Y is not finite at a point");
      if (i > 0 && !(x[i] > x[i - 1])) throw picard::Failure("X does not rise from each point to the next");
    }
  }

  void fire() override {
    if (std::isnan(in)) return;
    const double first = x[0];
    const double last = x[count_ - 1];
    outside = in < first || in > last;
    const double at = extrapolate && std::isfinite(in) ? in : std::clamp(in.get(), first, last);
    // The line that begins at the last point not after `at`; the outer lines serve what is outside.
    const auto begin = x->begin() + 1;
    const auto end = x->begin() + static_cast<std::ptrdiff_t>(count_) - 1;
    const auto i = static_cast<std::size_t>(std::upper_bound(begin, end, at) - x->begin()) - 1;
    out = std::lerp(y[i], y[i + 1], (at - x[i]) / (x[i + 1] - x[i]));
  }

 private:
  std::size_t count_ = 2;
};

}  // namespace plc::blocks
