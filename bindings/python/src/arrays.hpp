// SPDX-License-Identifier: MIT
#pragma once

#include <pybind11/numpy.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <string>

/// Between numpy and Eigen: a point is a row of an array, arrays are new and in C order.
namespace handyar::python {

namespace py = pybind11;

/// A matrix as it is, a vector as one row of numbers.
template <class Matrix>
py::array_t<double> array(const Matrix& matrix) {
  constexpr bool kVector = Matrix::ColsAtCompileTime == 1;
  py::array_t<double> result(kVector ? std::vector<py::ssize_t>{matrix.rows()}
                                     : std::vector<py::ssize_t>{matrix.rows(), matrix.cols()});
  double* to = result.mutable_data();
  for (Eigen::Index row = 0; row < matrix.rows(); ++row)
    for (Eigen::Index col = 0; col < matrix.cols(); ++col) *to++ = matrix(row, col);
  return result;
}

/// Points in the columns of a matrix, a row each.
template <class Matrix>
py::array_t<double> points(const Matrix& columns) {
  return array(columns.transpose());
}

inline py::array_t<double> array(const Eigen::Isometry3d& T) { return array(T.matrix()); }

/// What is there as an array, or None.
template <class Optional, class Get>
py::object or_none(const Optional& value, Get get) {
  return value ? py::object(array(get(*value))) : py::none();
}

using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// A fixed-size matrix from an array of just that shape. Throws ValueError that names it.
template <class Matrix>
Matrix matrix_of(const Numbers& numbers, const char* name) {
  constexpr int kRows = Matrix::RowsAtCompileTime, kCols = Matrix::ColsAtCompileTime;
  if (numbers.ndim() != 2 || numbers.shape(0) != kRows || numbers.shape(1) != kCols)
    throw py::value_error(std::string(name) + ": an array of shape (" + std::to_string(kRows) +
                          ", " + std::to_string(kCols) + ") is wanted");
  return Eigen::Map<const Eigen::Matrix<double, kRows, kCols, Eigen::RowMajor>>(numbers.data());
}

/// A pose from a 4x4 array. Throws ValueError when that is no rigid transform.
inline Eigen::Isometry3d isometry_of(const Numbers& numbers, const char* name) {
  const auto T = matrix_of<Eigen::Matrix4d>(numbers, name);
  const Eigen::Matrix3d R = T.topLeftCorner<3, 3>();
  constexpr double kTolerance = 1e-6;
  if (!T.allFinite() || !(R * R.transpose()).isIdentity(kTolerance) || R.determinant() < 0 ||
      !T.row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1), kTolerance))
    throw py::value_error(std::string(name) + ": not a rigid transform");
  return Eigen::Isometry3d(T);
}

/// Applies `f`, from one fixed vector to another, to each of an array's innermost rows.
template <int kFrom, int kTo, class Function>
py::array_t<double> each(const Numbers& numbers, const char* name, Function f) {
  if (numbers.ndim() < 1 || numbers.shape(numbers.ndim() - 1) != kFrom)
    throw py::value_error(std::string(name) + ": an array of shape (..., " + std::to_string(kFrom) +
                          ") is wanted");
  std::vector<py::ssize_t> shape(numbers.shape(), numbers.shape() + numbers.ndim());
  shape.back() = kTo;
  py::array_t<double> result(shape);
  const double* from = numbers.data();
  double* to = result.mutable_data();
  for (py::ssize_t i = 0; i < numbers.size() / kFrom; ++i, from += kFrom, to += kTo) {
    const Eigen::Matrix<double, kTo, 1> value =
        f(Eigen::Map<const Eigen::Matrix<double, kFrom, 1>>(from));
    std::copy_n(value.data(), kTo, to);
  }
  return result;
}

}  // namespace handyar::python
