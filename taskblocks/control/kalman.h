// KALMAN: linear Kalman filter, the states of a process from noisy measurements.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "picard/taskblock.h"
#include "taskblocks/control/kalman_filter.h"
#include "taskblocks/control/matrix.h"
#include "taskblocks/control/sample_time.h"

namespace plc::blocks {

class Kalman final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{
      .name = "KALMAN",
      .group = "Control",
      .summary = "Linear Kalman filter in discrete time: up to 8 states from up to 4 noisy measurements.",
      .details =
          "For a process `x+ = A x + B u + w`, `y = C x + v` with noise of the covariances Q (of w) and R (of v) each "
          "execution predicts with U, what acted on the process since the last one, and corrects with Y, what is "
          "measured "
          "now:\n\n"
          "`X := A X + B U`; `P := A P A' + Q`\n\n"
          "`S = C P C' + R`; `G = P C' / S`; `X := X + G (Y - C X)`; `P := (I - G C) P (I - G C)' + G R G'`\n\n"
          "A and Q are NX by NX, B NX by NU, C NY by NX, R NY by NY, P0 NX by NX. Their numbers are stored row by row "
          "from "
          "the "
          "start of the array, as many as the sizes say. Q and P0 must be symmetric and positive semidefinite, R "
          "symmetric "
          "and positive definite. TS is the sample time of the matrices; a task with another period, or with none, is "
          "refused. With TS = 0 every execution is a sample.\n\n"
          "The first execution, and each one with RESET, predicts nothing: it corrects X0, whose covariance is P0.\n\n"
          "A measurement with VALID FALSE is left out, and so is one that is NaN or infinite: the estimate goes on by "
          "the "
          "model, and VARIANCE grows. INNOVATION and INNOVATION_VARIANCE of what is left out are 0. NIS is the sum of "
          "the "
          "squared innovations in units of their covariance: about the number of measurements in use while the model "
          "is "
          "right, far above it when a sensor lies (9 is 3 sigma of a single one).\n\n"
          "BAD is TRUE while a measurement that is VALID is no finite number, an input is none (its last good value "
          "stands "
          "in), or a step is not taken because its result would be none; RESET starts anew. Sizes or numbers that make "
          "no "
          "sense are refused before the first cycle."};

  std::array<picard::Input<double>, kInputs> u{{{this, "U1", "first input of the process"},
                                                {this, "U2", "second input of the process"},
                                                {this, "U3", "third input of the process"},
                                                {this, "U4", "fourth input of the process"}}};
  std::array<picard::Input<double>, kMeasured> y{{{this, "Y1", "first measurement"},
                                                  {this, "Y2", "second measurement"},
                                                  {this, "Y3", "third measurement"},
                                                  {this, "Y4", "fourth measurement"}}};
  std::array<picard::Input<bool>, kMeasured> valid{{{this, "VALID1", "Y1 may be used", {.initial = "TRUE"}},
                                                    {this, "VALID2", "Y2 may be used", {.initial = "TRUE"}},
                                                    {this, "VALID3", "Y3 may be used", {.initial = "TRUE"}},
                                                    {this, "VALID4", "Y4 may be used", {.initial = "TRUE"}}}};
  picard::Input<bool> reset{this, "RESET", "starts anew at X0 and P0"};

  picard::Config<std::int16_t> nx{this, "NX", "number of states", {.lowest = 1, .highest = kStates, .initial = "1"}};
  picard::Config<std::int16_t> nu{this, "NU", "number of inputs", {.lowest = 0, .highest = kInputs}};
  picard::Config<std::int16_t> ny{
      this, "NY", "number of measurements", {.lowest = 1, .highest = kMeasured, .initial = "1"}};
  picard::Config<double> ts{this, "TS", "sample time of the matrices; 0: not checked", {.unit = "s", .lowest = 0}};
  picard::Config<std::array<double, kStates * kStates>> a{this, "A", "state to next state, row by row"};
  picard::Config<std::array<double, kStates * kInputs>> b{this, "B", "input to next state, row by row"};
  picard::Config<std::array<double, kMeasured * kStates>> c{this, "C", "state to measurement, row by row"};
  picard::Config<std::array<double, kStates * kStates>> q{this, "Q", "covariance of the process noise, row by row"};
  picard::Config<std::array<double, kMeasured * kMeasured>> r{this, "R", "covariance of the measurements, row by row"};
  picard::Config<std::array<double, kStates>> x0{this, "X0", "estimate at the start"};
  picard::Config<std::array<double, kStates * kStates>> p0{this, "P0", "covariance of X0, row by row"};

  picard::Output<std::array<double, kStates>> x{this, "X", "estimate of the states"};
  picard::Output<std::array<double, kStates>> variance{this, "VARIANCE", "variances of X: the diagonal of P"};
  picard::Output<std::array<double, kMeasured>> innovation{this, "INNOVATION", "Y - C X before the correction"};
  picard::Output<std::array<double, kMeasured>> innovation_variance{this, "INNOVATION_VARIANCE",
                                                                    "what INNOVATION varies by: the diagonal of S"};
  picard::Output<double> nis{this, "NIS", "normalised innovation squared"};
  picard::Output<bool> bad{this, "BAD", "a number is not finite"};

  void ready() override {
    check_sample_time(ts, period());
    KalmanModel model;
    model.a = read_matrix<kStates, kStates>(a.get(), nx, nx, "a number in A is not finite");
    model.b = read_matrix<kStates, kInputs>(b.get(), nx, nu, "a number in B is not finite");
    model.c = read_matrix<kMeasured, kStates>(c.get(), ny, nx, "a number in C is not finite");
    model.q = read_covariance<kStates>(q.get(), nx, "Q is not symmetric and positive semidefinite");
    model.r = read_covariance<kMeasured>(r.get(), ny, "R is not symmetric and positive definite");
    model.x0 = read_matrix<kStates, 1>(x0.get(), nx, 1, "a number in X0 is not finite");
    model.p0 = read_covariance<kStates>(p0.get(), nx, "P0 is not symmetric and positive semidefinite");
    if (!is_definite(model.r)) throw picard::Failure("R is not symmetric and positive definite");
    filter_ = KalmanFilter(model);
    inputs_ = Vector<kInputs>::Zero(nu.get());
  }

  void fire() override {
    bool good = true;
    for (int i = 0; i < nu; ++i) good = take_finite(u[static_cast<std::size_t>(i)], inputs_(i)) && good;
    Vector<kMeasured> measured = Vector<kMeasured>::Zero(ny.get());
    std::array<bool, kMeasured> used{};
    for (std::size_t i = 0; i < static_cast<std::size_t>(ny.get()); ++i) {
      used[i] = valid[i] && take_finite(y[i], measured(static_cast<int>(i)));
      good = good && (used[i] || !valid[i]);
    }
    if (!started_ || reset) {
      filter_.reset();
      started_ = true;
    } else {
      good = filter_.predict(inputs_) && good;
    }
    good = filter_.correct(measured, used) && good;
    bad = !good;
    show_vector<kStates>(filter_.estimate(), *x);
    show_vector<kStates>(filter_.variances(), *variance);
    show_vector<kMeasured>(filter_.innovations(), *innovation);
    show_vector<kMeasured>(filter_.innovation_variances(), *innovation_variance);
    nis = filter_.normalized_square();
  }

 private:
  KalmanFilter filter_;
  Vector<kInputs> inputs_;
  bool started_ = false;
};

}  // namespace plc::blocks
