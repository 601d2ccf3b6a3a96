// STATE_FEEDBACK: the law U = N R - K X for states that a sensor, an OBSERVER or a KALMAN knows.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "picard/taskblock.h"
#include "taskblocks/control/matrix.h"

namespace plc::blocks {

class StateFeedback final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{
      .name = "STATE_FEEDBACK",
      .group = "Control",
      .summary = "State feedback with set-points: U = N R - K X, up to 8 states, 4 outputs, 4 set-points.",
      .details =
          "X is an array as OBSERVER and KALMAN give it. K is NU by NX, N is NU by NR; their numbers are stored row by "
          "row "
          "from "
          "the start of the array, as many as the sizes say. K comes from pole placement or LQR for the sample time of "
          "the "
          "task. N makes the outputs that are to follow R do so at rest: for a process x+ = A x + B u, y = C x with as "
          "many of them as inputs, `N = inverse(C * inverse(I - A + B*K) * B)`.\n\n"
          "Each output is held within UMIN .. UMAX; where UMIN is not below UMAX it has no limits. To an OBSERVER or "
          "KALMAN "
          "give the limited U: what acts on the process.\n\n"
          "There is no memory: nothing to start, nothing to wind up. While a number in R or X is NaN or infinite, or a "
          "sum is, the outputs stay and BAD "
          "is TRUE."};

  std::array<picard::Input<double>, kMeasured> r{{{this, "R1", "first set-point"},
                                                  {this, "R2", "second set-point"},
                                                  {this, "R3", "third set-point"},
                                                  {this, "R4", "fourth set-point"}}};
  picard::Input<std::array<double, kStates>> x{this, "X", "state of the process"};

  picard::Config<std::int16_t> nx{this, "NX", "number of states", {.lowest = 1, .highest = kStates, .initial = "1"}};
  picard::Config<std::int16_t> nu{this, "NU", "number of outputs", {.lowest = 1, .highest = kInputs, .initial = "1"}};
  picard::Config<std::int16_t> nr{
      this, "NR", "number of set-points; 0: the state is brought to 0", {.lowest = 0, .highest = kMeasured}};
  picard::Config<std::array<double, kInputs * kStates>> k{this, "K", "state to output, row by row"};
  picard::Config<std::array<double, kInputs * kMeasured>> n{this, "N", "set-point to output, row by row"};
  picard::Config<std::array<double, kInputs>> umin{this, "UMIN", "least outputs; no limits where UMIN >= UMAX"};
  picard::Config<std::array<double, kInputs>> umax{this, "UMAX", "greatest outputs"};

  std::array<picard::Output<double>, kInputs> u{{{this, "U1", "first output"},
                                                 {this, "U2", "second output"},
                                                 {this, "U3", "third output"},
                                                 {this, "U4", "fourth output"}}};
  picard::Output<bool> bad{this, "BAD", "the outputs are held because a number is not finite"};

  void ready() override {
    k_ = read_matrix<kInputs, kStates>(k.get(), nu, nx, "a number in K is not finite");
    n_ = read_matrix<kInputs, kMeasured>(n.get(), nu, nr, "a number in N is not finite");
    for (std::size_t i = 0; i < kInputs; ++i) {
      if (std::isnan(umin[i]) || std::isnan(umax[i])) throw picard::Failure("a number in UMIN or UMAX is NaN");
    }
  }

  void fire() override {
    Vector<kStates> state(nx.get());
    for (int i = 0; i < nx; ++i) state(i) = x[static_cast<std::size_t>(i)];
    Vector<kMeasured> setpoints(nr.get());
    for (int i = 0; i < nr; ++i) setpoints(i) = r[static_cast<std::size_t>(i)];
    const Vector<kInputs> outputs = times(n_, setpoints) - times(k_, state);
    bad = !outputs.allFinite();
    if (bad) return;
    for (std::size_t i = 0; i < static_cast<std::size_t>(nu.get()); ++i) {
      const double value = outputs(static_cast<int>(i));
      u[i] = umin[i] < umax[i] ? std::clamp(value, umin[i], umax[i]) : value;
    }
  }

 private:
  Matrix<kInputs, kStates> k_;
  Matrix<kInputs, kMeasured> n_;
};

}  // namespace plc::blocks
