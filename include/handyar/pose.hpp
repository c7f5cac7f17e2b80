// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <limits>

#include "handyar/camera.hpp"
#include "handyar/hand_model.hpp"

namespace handyar {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Camera pose relative to the hand, from one frame (paper 2.5).
struct PoseEstimate {
  Eigen::Isometry3d T_camera_hand = Eigen::Isometry3d::Identity();

  /// Order: rotation (rad), translation (m). The rotation error is on the left, in camera axes:
  /// R_true = exp([w]x) R, t_true = t + d.
  Matrix6d covariance = Matrix6d::Zero();

  double rms_px = std::numeric_limits<double>::quiet_NaN();  ///< of the points used

  /// Residual of this solution over that of the other planar one: near 0 sure, near 1 ambiguous.
  double ambiguity = 0.0;

  /// Turn of each finger in the hand plane against the calibrated posture, towards the thumb
  /// positive; zero for methods that do not estimate it.
  std::array<double, kFingerCount> spread_rad{};
};

/// Root mean square standard deviation of rotation (rad) over the three axes.
double sigma_rotation_rad(const Matrix6d& covariance) noexcept;
/// Root mean square standard deviation of translation (m) over the three axes.
double sigma_translation_m(const Matrix6d& covariance) noexcept;

}  // namespace handyar
