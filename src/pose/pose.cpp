// SPDX-License-Identifier: MIT
#include "handyar/pose.hpp"

#include <cmath>

namespace handyar {

double sigma_rotation_rad(const Matrix6d& covariance) noexcept {
  return std::sqrt(covariance.topLeftCorner<3, 3>().trace() / 3);
}

double sigma_translation_m(const Matrix6d& covariance) noexcept {
  return std::sqrt(covariance.bottomRightCorner<3, 3>().trace() / 3);
}

}  // namespace handyar
