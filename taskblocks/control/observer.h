// OBSERVER: Luenberger observer, the states of a process from what can be measured of it.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "picard/taskblock.h"
#include "taskblocks/control/matrix.h"
#include "taskblocks/control/sample_time.h"

namespace plc::blocks {

class Observer final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{
      .name = "OBSERVER",
      .group = "Control",
      .summary = "Luenberger observer with a gain of your own: up to 8 states from up to 4 measurements.",
      .details =
          "For a process `x+ = A x + B u`, `y = C x` each execution predicts with U, what acted on the process since "
          "the "
          "last one, and corrects with Y, what is measured now:\n\n"
          "`X := A X + B U`; `X := X + L (Y - C X)`\n\n"
          "The error of X decays with the eigenvalues of (I - L C) A: place them by L. A gain Lp made for the "
          "predicting "
          "form, with eigenvalues of A - Lp C, is A L. Where noise is known, use KALMAN.\n\n"
          "A is NX by NX, B NX by NU, C NY by NX, L NX by NY. Their numbers are stored row by row from the start of "
          "the "
          "array, as "
          "many as the sizes say. TS is the sample time of the matrices; a task with another period, or with none, is "
          "refused. With TS = 0 every execution is a sample.\n\n"
          "The first execution, and each one with RESET, predicts nothing: it corrects X0. A measurement that is NaN "
          "or "
          "infinite corrects nothing, an input that is keeps its last good value, a step to states that are not finite "
          "is not "
          "taken; BAD is TRUE in all three. Sizes or numbers that make no sense are refused before the first cycle."};

  std::array<picard::Input<double>, kInputs> u{{{this, "U1", "first input of the process"},
                                                {this, "U2", "second input of the process"},
                                                {this, "U3", "third input of the process"},
                                                {this, "U4", "fourth input of the process"}}};
  std::array<picard::Input<double>, kMeasured> y{{{this, "Y1", "first measurement"},
                                                  {this, "Y2", "second measurement"},
                                                  {this, "Y3", "third measurement"},
                                                  {this, "Y4", "fourth measurement"}}};
  picard::Input<bool> reset{this, "RESET", "starts anew at X0"};

  picard::Config<std::int16_t> nx{this, "NX", "number of states", {.lowest = 1, .highest = kStates, .initial = "1"}};
  picard::Config<std::int16_t> nu{this, "NU", "number of inputs", {.lowest = 0, .highest = kInputs, .initial = "1"}};
  picard::Config<std::int16_t> ny{
      this, "NY", "number of measurements", {.lowest = 1, .highest = kMeasured, .initial = "1"}};
  picard::Config<double> ts{this, "TS", "sample time of the matrices; 0: not checked", {.unit = "s", .lowest = 0}};
  picard::Config<std::array<double, kStates * kStates>> a{this, "A", "state to next state, row by row"};
  picard::Config<std::array<double, kStates * kInputs>> b{this, "B", "input to next state, row by row"};
  picard::Config<std::array<double, kMeasured * kStates>> c{this, "C", "state to measurement, row by row"};
  picard::Config<std::array<double, kStates * kMeasured>> l{this, "L", "innovation to state, row by row"};
  picard::Config<std::array<double, kStates>> x0{this, "X0", "estimate at the start"};

  picard::Output<std::array<double, kStates>> x{this, "X", "estimate of the states"};
  picard::Output<std::array<double, kMeasured>> innovation{this, "INNOVATION", "Y - C X before the correction"};
  picard::Output<bool> bad{this, "BAD", "an input, a measurement or the next estimate is no finite number"};

  void ready() override {
    check_sample_time(ts, period());
    a_ = read_matrix<kStates, kStates>(a.get(), nx, nx, "a number in A is not finite");
    b_ = read_matrix<kStates, kInputs>(b.get(), nx, nu, "a number in B is not finite");
    c_ = read_matrix<kMeasured, kStates>(c.get(), ny, nx, "a number in C is not finite");
    l_ = read_matrix<kStates, kMeasured>(l.get(), nx, ny, "a number in L is not finite");
    x0_ = read_matrix<kStates, 1>(x0.get(), nx, 1, "a number in X0 is not finite");
    state_ = x0_;
    inputs_ = Vector<kInputs>::Zero(nu.get());
  }

  void fire() override {
    bool good = true;
    for (int i = 0; i < nu; ++i) good = take_finite(u[static_cast<std::size_t>(i)], inputs_(i)) && good;
    Vector<kStates> next = x0_;
    if (started_ && !reset) next = times(a_, state_) + times(b_, inputs_);
    started_ = true;
    const Vector<kMeasured> expected = times(c_, next);
    Vector<kMeasured> innovations = Vector<kMeasured>::Zero(ny.get());
    for (int i = 0; i < ny; ++i) {
      const double measured = y[static_cast<std::size_t>(i)];
      good = take_finite(measured - expected(i), innovations(i)) && good;
    }
    next += times(l_, innovations);
    if (next.allFinite()) {
      state_ = next;
      show_vector<kStates>(state_, *x);
      show_vector<kMeasured>(innovations, *innovation);
    } else {
      good = false;
    }
    bad = !good;
  }

 private:
  Matrix<kStates, kStates> a_;
  Matrix<kStates, kInputs> b_;
  Matrix<kMeasured, kStates> c_;
  Matrix<kStates, kMeasured> l_;
  Vector<kStates> x0_;
  Vector<kStates> state_;
  Vector<kInputs> inputs_;
  bool started_ = false;
};

}  // namespace plc::blocks
