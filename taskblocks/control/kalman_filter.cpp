#include "taskblocks/control/kalman_filter.h"

#include <Eigen/Cholesky>

namespace plc::blocks {
namespace {

using States = Matrix<kStates, kStates>;
using Measurements = Matrix<kMeasured, kMeasured>;

/// m * p * transposed m, exactly symmetric.
template <int Rows, int Columns>
Matrix<Rows, Rows> spread(const Matrix<Rows, Columns>& m, const Matrix<Columns, Columns>& p) {
  const Matrix<Rows, Columns> half = times(m, p);
  const Matrix<Rows, Rows> whole = times(half, m.transpose());
  return (whole + whole.transpose()) / 2;
}

}  // namespace

KalmanFilter::KalmanFilter(const KalmanModel& model)
    : model_(model),
      innovation_(Vector<kMeasured>::Zero(model.c.rows())),
      innovation_variance_(Vector<kMeasured>::Zero(model.c.rows())) {
  reset();
}

bool KalmanFilter::predict(const Vector<kInputs>& u) noexcept {
  const Vector<kStates> x = times(model_.a, x_) + times(model_.b, u);
  const States p = spread(model_.a, p_) + model_.q;
  if (!x.allFinite() || !p.allFinite()) return false;
  x_ = x;
  p_ = p;
  return true;
}

bool KalmanFilter::correct(const Vector<kMeasured>& y, const std::array<bool, kMeasured>& used) noexcept {
  // A measurement that is not used becomes one of nothing, with a noise of its own: its column of the gain is 0.
  Matrix<kMeasured, kStates> c = model_.c;
  Measurements r = model_.r;
  Vector<kMeasured> innovation = Vector<kMeasured>::Zero(y.size());
  for (int i = 0; i < y.size(); ++i) {
    if (used[static_cast<std::size_t>(i)]) {
      innovation(i) = y(i) - model_.c.row(i).dot(x_);
    } else {
      c.row(i).setZero();
      r.row(i).setZero();
      r.col(i).setZero();
      r(i, i) = 1;
    }
  }
  const Measurements s = spread(c, p_) + r;
  const Eigen::LLT<Measurements> factors(s);
  if (factors.info() != Eigen::Success) return false;
  const Matrix<kMeasured, kStates> cp = times(c, p_);
  const Matrix<kMeasured, kStates> transposed = factors.solve(cp);
  const Vector<kMeasured> weighted = factors.solve(innovation);
  const Matrix<kStates, kMeasured> gain = transposed.transpose();
  const Vector<kStates> x = x_ + times(gain, innovation);
  const States rest = States::Identity(x_.size(), x_.size()) - times(gain, c);
  const States p = spread(rest, p_) + spread(gain, r);
  if (!x.allFinite() || !p.allFinite()) return false;
  x_ = x;
  p_ = p;
  innovation_ = innovation;
  normalized_square_ = innovation.dot(weighted);
  for (int i = 0; i < y.size(); ++i) innovation_variance_(i) = used[static_cast<std::size_t>(i)] ? s(i, i) : 0;
  return true;
}

}  // namespace plc::blocks
