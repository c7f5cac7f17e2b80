// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <optional>

#include "handyar/pose.hpp"

namespace handyar {

inline constexpr int kMaxPosePoints = kFingerCount + kValleyCount;

/// A point of the hand, how uncertain its place on the hand is, and where it was seen.
struct PosePoint {
  Eigen::Vector3d hand_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
  Eigen::Vector2d px = Eigen::Vector2d::Zero();
  double sigma_px = 1.0;
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< of the finger or the opening, unit
  double radius_m = 0;  ///< of the round end, see outline_end_m; 0: a fixed point
  Eigen::Matrix3d wander_m2 = Eigen::Matrix3d::Zero();     ///< added to covariance_m2 edge on
  int finger = -1;                                         ///< whose tip it is; -1 for a valley
  Eigen::Vector3d per_spread_m = Eigen::Vector3d::Zero();  ///< displacement per radian of spread
  double spread_sigma_rad = 0.0;                           ///< prior of that spread
};

struct PosePoints {
  std::array<PosePoint, kMaxPosePoints> at;
  int count = 0;

  const PosePoint* begin() const { return at.data(); }
  const PosePoint* end() const { return at.data() + count; }
  void push_back(const PosePoint& p) { at[count++] = p; }
  PosePoints without(int index) const;
};

/// A pose and how well it fits.
struct FittedPose {
  Eigen::Isometry3d T_camera_hand = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Zero();        ///< as in PoseEstimate, noise as stated
  Matrix6d noise_covariance = Matrix6d::Zero();  ///< the part from pixel noise
  double deviance = 0;                           ///< squared error in standard deviations, robust
  double chi2 = 0;                               ///< the same, all points at full weight
  double rms_px = 0;                             ///< of the fingertips, by pixel noise weighted
};

/// Displacement of the image of a point: pixel residual (seen - projected) and its derivative by
/// rotation and translation errors as in PoseEstimate::covariance. False behind the camera.
bool reprojection(const PosePoint& point, const Camera& camera, const Eigen::Isometry3d& T,
                  Eigen::Vector2d& residual_px, Eigen::Matrix<double, 2, 6>& J_pose,
                  Eigen::Matrix<double, 2, 3>& J_hand_m);

/// The best fit near `start`: Levenberg-Marquardt on SE(3) with Huber weights. What is uncertain of
/// each point on the hand (finger spread, relief) is not a variable of its own: the points being
/// independent, marginalising it leaves a 2x2 covariance of each residual. Empty when points come
/// to lie behind the camera or do not determine the pose.
std::optional<FittedPose> refine(const PosePoints& points, const Camera& camera, double huber,
                                 const Eigen::Isometry3d& start);

/// Turn of a finger that explains its tip's residual best, given its prior.
double spread_rad(const PosePoint& point, const Camera& camera, const Eigen::Isometry3d& T);

}  // namespace handyar
