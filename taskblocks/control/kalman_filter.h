// KalmanFilter: the linear Kalman filter in discrete time, without ports.
//
// In: a model with its covariances, then inputs and measurements. Out: the estimate, its covariance, the innovations.
// Notation of Simon, "Optimal State Estimation" (2006), 5.1. The covariance is corrected in Joseph's form: symmetric,
// and insensitive to a gain that is rounded. RT. Does not belong here: ports, what is valid (kalman.h).
#pragma once

#include <array>

#include "taskblocks/control/matrix.h"

namespace plc::blocks {

/// Sizes that belong together: of `a` the number of states, of `b` that of inputs, of `c` that of measurements.
struct KalmanModel {
  Matrix<kStates, kStates> a;
  Matrix<kStates, kInputs> b;
  Matrix<kMeasured, kStates> c;
  Matrix<kStates, kStates> q;      ///< covariance of the noise of a step
  Matrix<kMeasured, kMeasured> r;  ///< covariance of the measurements
  Vector<kStates> x0;
  Matrix<kStates, kStates> p0;  ///< covariance of x0
};

class KalmanFilter {
 public:
  KalmanFilter() = default;
  explicit KalmanFilter(const KalmanModel& model);

  void reset() noexcept {
    x_ = model_.x0;
    p_ = model_.p0;
  }
  /// One sample on. False, and nothing changed, when the result would not be finite.
  bool predict(const Vector<kInputs>& u) noexcept;
  /// Takes the measurements that are `used`. False, and nothing changed, when the result would not be finite.
  bool correct(const Vector<kMeasured>& y, const std::array<bool, kMeasured>& used) noexcept;

  [[nodiscard]] const Vector<kStates>& estimate() const noexcept { return x_; }
  [[nodiscard]] Vector<kStates> variances() const noexcept { return p_.diagonal(); }
  /// Of the last correction: measurement - expectation, 0 where it was not used.
  [[nodiscard]] const Vector<kMeasured>& innovations() const noexcept { return innovation_; }
  /// Their variances; 0 where the measurement was not used.
  [[nodiscard]] const Vector<kMeasured>& innovation_variances() const noexcept { return innovation_variance_; }
  /// Innovations, squared and weighted with the inverse of their covariance: chi-squared with as many degrees of
  /// freedom as measurements were used, when the model is right.
  [[nodiscard]] double normalized_square() const noexcept { return normalized_square_; }

 private:
  KalmanModel model_;
  Vector<kStates> x_;
  Matrix<kStates, kStates> p_;
  Vector<kMeasured> innovation_;
  Vector<kMeasured> innovation_variance_;
  double normalized_square_ = 0;
};

}  // namespace plc::blocks
