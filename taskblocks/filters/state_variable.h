// The second-order filter behind LOWPASS2 and NOTCH: the state variable filter, integrated by the trapezoidal rule
// (V. Zavalishin, The Art of VA Filter Design, 2012, section 4). Its transfer functions are those of the bilinear
// transform,
// but its states are the signals of the analogue circuit: coefficients may change in every step, because the time
// between two samples did or because it is being tuned, without a jump. In: samples, coefficients. Ports and limits of
// coefficients belong to the blocks.
#pragma once

namespace plc::blocks {

class StateVariableFilter {
 public:
  struct Outputs {
    double low = 0;    ///< 1 / (s^2 + k s + 1)
    double notch = 0;  ///< (s^2 + 1) / (s^2 + k s + 1)
  };

  /// RT: the state that a constant `in` leads to.
  void settle(double in) noexcept {
    band_ = 0;
    low_ = in;
  }

  /// RT: one sample. `g` = tan(pi f dt), which puts the corner or centre exactly at the frequency f; `k` is the
  /// damping, 1/Q. Both are finite; g > 0, k >= 0.
  Outputs step(double in, double g, double k) noexcept {
    const double high = in - low_;
    const double scale = 1 / (1 + g * (g + k));
    const double band = scale * (band_ + g * high);
    const double low = low_ + g * band;
    band_ = 2 * band - band_;
    low_ = 2 * low - low_;
    return {low, in - k * band};
  }

 private:
  double band_ = 0;  ///< of the two integrators
  double low_ = 0;
};

}  // namespace plc::blocks
