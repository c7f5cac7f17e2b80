// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>

#include "handyar/api.h"

namespace handyar {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// A hand goes on as it went, or speeds up, for about so long; no frame counts for more time.
inline constexpr double kLongest_s = 0.1;
/// So long a hand is remembered, and moves in one manner.
inline constexpr double kRemembered_s = 1.0;

/// Pose of the hand in the camera, from one frame (paper 2.5).
struct PoseEstimate {
  Eigen::Isometry3d T_camera_hand = Eigen::Isometry3d::Identity();

  /// Order: rotation (rad), translation (m). The rotation error is on the left, in camera axes:
  /// R_true = exp([w]x) R, t_true = t + d.
  Matrix6d covariance = Matrix6d::Zero();

  /// The part of `covariance` that is new in each frame; the rest stays as long as hand and view
  /// do, and no filter can average it out.
  Matrix6d noise_covariance = Matrix6d::Zero();

  /// Root mean square distance between what was seen and the hand in this pose: of the outline, or,
  /// by the paper's method, of the fingertips.
  double rms_px = std::numeric_limits<double>::quiet_NaN();
};

/// A filtered pose with its velocities, at a stated time.
struct FilteredPose {
  double time_s = 0;
  Eigen::Isometry3d T_camera_hand = Eigen::Isometry3d::Identity();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_velocity_rad_s = Eigen::Vector3d::Zero();  ///< in camera axes
  Matrix6d covariance = Matrix6d::Zero();                            ///< as in PoseEstimate
};

/// Root mean square standard deviation of rotation (rad) over the three axes.
[[nodiscard]] HANDYAR_API double sigma_rotation_rad(const Matrix6d& covariance) noexcept;
/// Root mean square standard deviation of translation (m) over the three axes.
[[nodiscard]] HANDYAR_API double sigma_translation_m(const Matrix6d& covariance) noexcept;

}  // namespace handyar
