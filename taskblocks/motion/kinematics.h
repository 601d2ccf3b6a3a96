// KINEMATICS: axes and motors that depend on each other linearly, both ways.
#pragma once

#include <Eigen/LU>
#include <Eigen/SVD>
#include <array>
#include <cmath>
#include <cstdint>

#include "picard/taskblock.h"

namespace plc::blocks {

class Kinematics final : public picard::Taskblock {
 public:
  static constexpr std::size_t kMostAxes = 6;
  static constexpr picard::Info info{
      .name = "KINEMATICS",
      .group = "Motion",
      .summary = "Motor positions from axis positions by a matrix, and axis positions back from the motors'.",
      .details =
          "MOTORS = M AXES + OFFSET and AXES_ACTUAL = M^-1 (MOTORS_ACTUAL - OFFSET), for COUNT axes: belts of a "
          "CoreXY gantry, differential wrists, gears, squareness corrections. MATRIX holds M row by row: the element "
          "in row r, column c, from 0, is MATRIX[COUNT r + c]. Elements beyond COUNT are ignored, and 0 in "
          "outputs.\n\n"
          "The inverse is made once, before the first cycle. A matrix that has none, or whose condition number "
          "(largest by smallest singular value: by how much it can magnify relative errors) is above MAX_CONDITION, "
          "is refused, and so are numbers that are none. CONDITION tells it. What is not a number in AXES is none in "
          "MOTORS."};

  picard::Config<std::int16_t> count{
      this, "COUNT", "axes, and as many motors", {.lowest = 1, .highest = kMostAxes, .initial = "2"}};
  picard::Config<std::array<double, kMostAxes * kMostAxes>> matrix{this, "MATRIX", "M, row by row"};
  picard::Config<std::array<double, kMostAxes>> offset{this, "OFFSET", "motor positions when all axes are at 0"};
  picard::Config<double> max_condition{
      this, "MAX_CONDITION", "highest condition number", {.lowest = 1, .initial = "1.0E6"}};
  picard::Input<std::array<double, kMostAxes>> axes{this, "AXES", "wanted axis positions"};
  picard::Input<std::array<double, kMostAxes>> motors_actual{this, "MOTORS_ACTUAL", "measured motor positions"};
  picard::Output<std::array<double, kMostAxes>> motors{this, "MOTORS", "motor positions for AXES"};
  picard::Output<std::array<double, kMostAxes>> axes_actual{this, "AXES_ACTUAL", "axis positions for MOTORS_ACTUAL"};
  picard::Output<double> condition{this, "CONDITION", "condition number of M"};

  void ready() override {
    n_ = static_cast<std::size_t>(count);
    const auto n = static_cast<Eigen::Index>(n_);
    m_.resize(n, n);
    offset_.resize(n);
    for (Eigen::Index row = 0; row < n; ++row) {
      for (Eigen::Index column = 0; column < n; ++column) {
        m_(row, column) = matrix[static_cast<std::size_t>(n * row + column)];
      }
      offset_(row) = offset[static_cast<std::size_t>(row)];
    }
    if (!m_.allFinite() || !offset_.allFinite()) {
      throw picard::Failure("KINEMATICS: MATRIX and OFFSET must be finite numbers");
    }
    // Matrices that are not square would need a preconditioner, which takes long to compile.
    const auto singular_values = Eigen::JacobiSVD<Matrix, Eigen::NoQRPreconditioner>(m_).singularValues();
    const double smallest = singular_values(n - 1);
    condition_ = smallest > 0 ? singular_values(0) / smallest : std::numeric_limits<double>::infinity();
    if (!(condition_ <= max_condition)) {
      throw picard::Failure("KINEMATICS: MATRIX has no inverse, or one with a condition number above MAX_CONDITION");
    }
    inverse_ = m_.inverse();
  }

  void fire() override {
    Vector in = load(axes);
    Vector out = offset_;
    out.noalias() += m_.lazyProduct(in);
    store(out, *motors);
    in = load(motors_actual) - offset_;
    out.noalias() = inverse_.lazyProduct(in);
    store(out, *axes_actual);
    condition = condition_;
  }

 private:
  static constexpr int kMost = static_cast<int>(kMostAxes);
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, kMost, kMost>;
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMost, 1>;

  [[nodiscard]] Vector load(const std::array<double, kMostAxes>& from) const {
    return Eigen::Map<const Vector>(from.data(), static_cast<Eigen::Index>(n_));
  }
  void store(const Vector& from, std::array<double, kMostAxes>& to) const {
    for (std::size_t i = 0; i < n_; ++i) to[i] = from(static_cast<Eigen::Index>(i));
  }

  std::size_t n_ = 0;
  Matrix m_;
  Matrix inverse_;
  Vector offset_;
  double condition_ = 0;
};

}  // namespace plc::blocks
