// STATE_SPACE: a linear model in discrete time.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "picard/taskblock.h"
#include "taskblocks/control/matrix.h"
#include "taskblocks/control/sample_time.h"

namespace plc::blocks {

class StateSpace final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{
      .name = "STATE_SPACE",
      .group = "Control",
      .summary =
          "Linear model in discrete time, up to 8 states, 4 inputs, 4 outputs: a controller, a filter, a process.",
      .details =
          "Each execution gives Y and then moves on by one sample:\n\n"
          "`Y = C x + D U`, held within YMIN .. YMAX; `x := A x + B U`\n\n"
          "A is NX by NX, B NX by NU, C NY by NX, D NY by NU. Their numbers are stored row by row from the start of "
          "the "
          "array, as "
          "many as the sizes say: with NX = 2, A is [a11, a12, a21, a22]. Outputs and states that are not used are "
          "0.\n\n"
          "The matrices are made for one sample time. TS says which; a task with another period, or with none, is "
          "refused "
          "then. With TS = 0 every execution is a sample.\n\n"
          "The first execution starts at x = X0, and so does each one with RESET. X is the state that Y was made of. "
          "Where "
          "YMIN is not below YMAX an output has no limits; the state does not notice limits.\n\n"
          "While an input is NaN or infinite its last good value stands in, and BAD is TRUE. A step to a state that is "
          "not finite (a model that is not stable) is not taken, and BAD is TRUE; RESET starts anew. Sizes or numbers "
          "that "
          "make no sense are refused before the first cycle."};

  std::array<picard::Input<double>, kInputs> u{{{this, "U1", "first input"},
                                                {this, "U2", "second input"},
                                                {this, "U3", "third input"},
                                                {this, "U4", "fourth input"}}};
  picard::Input<bool> reset{this, "RESET", "the state is X0"};

  picard::Config<std::int16_t> nx{this, "NX", "number of states", {.lowest = 1, .highest = kStates, .initial = "1"}};
  picard::Config<std::int16_t> nu{this, "NU", "number of inputs", {.lowest = 1, .highest = kInputs, .initial = "1"}};
  picard::Config<std::int16_t> ny{this, "NY", "number of outputs", {.lowest = 1, .highest = kMeasured, .initial = "1"}};
  picard::Config<double> ts{this, "TS", "sample time of the matrices; 0: not checked", {.unit = "s", .lowest = 0}};
  picard::Config<std::array<double, kStates * kStates>> a{this, "A", "state to next state, row by row"};
  picard::Config<std::array<double, kStates * kInputs>> b{this, "B", "input to next state, row by row"};
  picard::Config<std::array<double, kMeasured * kStates>> c{this, "C", "state to output, row by row"};
  picard::Config<std::array<double, kMeasured * kInputs>> d{this, "D", "input to output, row by row"};
  picard::Config<std::array<double, kStates>> x0{this, "X0", "state at the start"};
  picard::Config<std::array<double, kMeasured>> ymin{this, "YMIN", "least outputs; no limits where YMIN >= YMAX"};
  picard::Config<std::array<double, kMeasured>> ymax{this, "YMAX", "greatest outputs"};

  std::array<picard::Output<double>, kMeasured> y{{{this, "Y1", "first output"},
                                                   {this, "Y2", "second output"},
                                                   {this, "Y3", "third output"},
                                                   {this, "Y4", "fourth output"}}};
  picard::Output<std::array<double, kStates>> x{this, "X", "state that the outputs were made of"};
  picard::Output<bool> bad{this, "BAD", "an input, or the next state, is no finite number"};

  void ready() override {
    check_sample_time(ts, period());
    a_ = read_matrix<kStates, kStates>(a.get(), nx, nx, "a number in A is not finite");
    b_ = read_matrix<kStates, kInputs>(b.get(), nx, nu, "a number in B is not finite");
    c_ = read_matrix<kMeasured, kStates>(c.get(), ny, nx, "a number in C is not finite");
    d_ = read_matrix<kMeasured, kInputs>(d.get(), ny, nu, "a number in D is not finite");
    x0_ = read_matrix<kStates, 1>(x0.get(), nx, 1, "a number in X0 is not finite");
    for (std::size_t i = 0; i < kMeasured; ++i) {
      if (std::isnan(ymin[i]) || std::isnan(ymax[i])) throw picard::Failure("a number in YMIN or YMAX is NaN");
    }
    state_ = x0_;
    inputs_ = Vector<kInputs>::Zero(nu.get());
  }

  void fire() override {
    bool good = true;
    for (int i = 0; i < nu; ++i) good = take_finite(u[static_cast<std::size_t>(i)], inputs_(i)) && good;
    if (reset) state_ = x0_;
    show_vector<kStates>(state_, *x);
    const Vector<kMeasured> outputs = times(c_, state_) + times(d_, inputs_);
    for (std::size_t i = 0; i < static_cast<std::size_t>(ny.get()); ++i) {
      double value = outputs(static_cast<int>(i));
      if (ymin[i] < ymax[i]) value = std::clamp(value, ymin[i], ymax[i]);
      good = take_finite(value, *y[i]) && good;
    }
    const Vector<kStates> next = times(a_, state_) + times(b_, inputs_);
    if (next.allFinite()) {
      state_ = next;
    } else {
      good = false;
    }
    bad = !good;
  }

 private:
  Matrix<kStates, kStates> a_;
  Matrix<kStates, kInputs> b_;
  Matrix<kMeasured, kStates> c_;
  Matrix<kMeasured, kInputs> d_;
  Vector<kStates> x0_;
  Vector<kStates> state_;
  Vector<kInputs> inputs_;
};

}  // namespace plc::blocks
