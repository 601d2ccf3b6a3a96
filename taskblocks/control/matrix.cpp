#include "taskblocks/control/matrix.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace plc::blocks {

bool is_covariance(const Matrix<kStates, kStates>& matrix) {
  constexpr double kRounding = 1e-9;
  const double scale = matrix.cwiseAbs().maxCoeff();
  if ((matrix - matrix.transpose()).cwiseAbs().maxCoeff() > kRounding * scale) return false;
  const Eigen::SelfAdjointEigenSolver<Matrix<kStates, kStates>> solver(matrix, Eigen::EigenvaluesOnly);
  return !(solver.eigenvalues().minCoeff() < -kRounding * scale);
}

bool is_definite(const Matrix<kStates, kStates>& matrix) {
  return Eigen::LLT<Matrix<kStates, kStates>>(matrix).info() == Eigen::Success;
}

}  // namespace plc::blocks
