#include "taskblocks/control/kalman_filter.h"

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
  Vector<kMeasured> innovation = Vector<kMeasured>::Zero();
  for (int i = 0; i < kMeasured; ++i) {
    if (used[static_cast<std::size_t>(i)]) {
      innovation(i) = y(i) - times(model_.c.row(i), x_).value();
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
  const Matrix<kMeasured, kStates> gain = factors.solve(cp);  // transposed
  const Vector<kMeasured> weighted = factors.solve(innovation);
  const Vector<kStates> x = x_ + times(gain.transpose(), innovation);
  const States rest = States::Identity() - times(gain.transpose(), c);
  const States p = spread(rest, p_) + spread<kStates, kMeasured>(gain.transpose(), r);
  if (!x.allFinite() || !p.allFinite()) return false;
  x_ = x;
  p_ = p;
  innovation_ = innovation;
  normalized_square_ = innovation.dot(weighted);
  for (int i = 0; i < kMeasured; ++i) innovation_variance_(i) = used[static_cast<std::size_t>(i)] ? s(i, i) : 0;
  return true;
}

}  // namespace plc::blocks
