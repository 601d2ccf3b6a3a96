// Matrices of the models in discrete time: of the sizes in use, with room for the largest.
//
// In: numbers of configuration ports, row by row. Out: matrices without memory on the heap, whose products ask for none
// either. RT except for reading and checking, which are for ready(). Does not belong here: models.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>

#include "picard/taskblock.h"

namespace plc::blocks {

inline constexpr int kStates = 8;
inline constexpr int kInputs = 4;
inline constexpr int kMeasured = 4;  ///< outputs of a model, measurements of an estimator

/// Of any size up to this one.
template <int MostRows, int MostColumns>
using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, MostRows, MostColumns>;
template <int Most>
using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, Most, 1>;

/// The first rows * columns numbers, row by row. Throws `complaint`, a literal, when one of them is no finite number.
template <int Rows, int Columns, std::size_t Count>
Matrix<Rows, Columns> read_matrix(const std::array<double, Count>& numbers, int rows, int columns,
                                  const char* complaint) {
  static_assert(Count >= static_cast<std::size_t>(Rows) * Columns);
  Matrix<Rows, Columns> matrix(rows, columns);
  for (int i = 0; i < rows; ++i) {
    for (int k = 0; k < columns; ++k) {
      const double number = numbers[static_cast<std::size_t>(i * columns + k)];
      if (!std::isfinite(number)) throw picard::Failure(complaint);
      matrix(i, k) = number;
    }
  }
  return matrix;
}

/// Symmetric and positive semidefinite, but for rounding.
bool is_covariance(const Matrix<kStates, kStates>& matrix);
/// Symmetric matrices only: positive definite.
bool is_definite(const Matrix<kStates, kStates>& matrix);

/// The same for a covariance: throws `complaint` also when it is none.
template <int Size, std::size_t Count>
Matrix<Size, Size> read_covariance(const std::array<double, Count>& numbers, int size, const char* complaint) {
  Matrix<Size, Size> matrix = read_matrix<Size, Size>(numbers, size, size, complaint);
  if (!is_covariance(matrix)) throw picard::Failure(complaint);
  return matrix;
}

/// a * b without Eigen's blocked product, which is made for large matrices and copies them.
template <class A, class B>
auto times(const Eigen::MatrixBase<A>& a, const Eigen::MatrixBase<B>& b) {
  return a.lazyProduct(b);
}

/// The value of a pin that may break: while it is NaN or infinite, what it was last. False in that case.
inline bool take_finite(double value, double& kept) {
  if (!std::isfinite(value)) return false;
  kept = value;
  return true;
}

/// As the first elements of an array.
template <std::size_t Count, int Size>
void show_vector(const Vector<Size>& vector, std::array<double, Count>& numbers) {
  static_assert(Count == Size);
  for (int i = 0; i < vector.size(); ++i) numbers[static_cast<std::size_t>(i)] = vector(i);
}

}  // namespace plc::blocks
