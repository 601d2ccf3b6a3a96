// BIQUAD: any second-order filter, by its coefficients. Direct form II transposed.
#pragma once

#include <cmath>

#include "picard/taskblock.h"

namespace plc::blocks {

class Biquad final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{
      .name = "BIQUAD",
      .group = "Filters",
      .summary = "Second-order filter given by its coefficients.",
      .details =
          "`OUT(n) = B0 IN(n) + B1 IN(n-1) + B2 IN(n-2) - A1 OUT(n-1) - A2 OUT(n-2)`, the transfer function "
          "`(B0 + B1 z^-1 + B2 z^-2) / (1 + A1 z^-1 + A2 z^-2)` as design tools print it; a tool that gives A0 has all "
          "others divided by it. Mind the signs of A1 and A2, which some tools print the other way round. "
          "Coefficients belong to one rate of execution: the block is meant for cyclic tasks. Filters of higher order "
          "are several blocks in a row. Coefficients may change while it runs (direct form II transposed).\n\n"
          "The first cycle and RESET start in the state that a constant IN leads to; when there is none, because the "
          "filter integrates or is unstable, at rest.\n\n"
          "STABLE tells that both poles lie inside of the unit circle: |A2| < 1 and |A1| < 1 + A2. An unstable filter "
          "runs as told; when it leaves the range of numbers it starts anew. While IN or a coefficient is no finite "
          "number OUT stays as it is; before the first one it is 0."};

  picard::Input<double> in{this, "IN", "signal"};
  picard::Input<double> b0{this, "B0", "coefficient of IN", {.initial = "1.0"}};
  picard::Input<double> b1{this, "B1", "coefficient of IN one cycle ago"};
  picard::Input<double> b2{this, "B2", "coefficient of IN two cycles ago"};
  picard::Input<double> a1{this, "A1", "coefficient of OUT one cycle ago"};
  picard::Input<double> a2{this, "A2", "coefficient of OUT two cycles ago"};
  picard::Input<bool> reset{this, "RESET", "TRUE: start anew at IN"};
  picard::Output<double> out{this, "OUT", "filtered signal"};
  picard::Output<bool> stable{this, "STABLE", "the coefficients are those of a stable filter"};

  void fire() override {
    stable = std::abs(a2) < 1 && std::abs(a1) < 1 + a2;
    if (!std::isfinite(in) || !std::isfinite(b0) || !std::isfinite(b1) || !std::isfinite(b2) || !std::isfinite(a1) ||
        !std::isfinite(a2)) {
      return;
    }
    if (!started_ || reset) settle();
    double value = b0 * in + s1_;
    if (!std::isfinite(value)) {
      settle();
      value = b0 * in + s1_;
    }
    s1_ = b1 * in - a1 * value + s2_;
    s2_ = b2 * in - a2 * value;
    out = value;
  }

 private:
  void settle() {
    started_ = true;
    const double steady = stable ? (b0 + b1 + b2) / (1 + a1 + a2) * in : 0;
    s2_ = stable ? b2 * in - a2 * steady : 0;
    s1_ = stable ? b1 * in - a1 * steady + s2_ : 0;
  }

  bool started_ = false;
  double s1_ = 0;
  double s2_ = 0;
};

}  // namespace plc::blocks
