// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <span>

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
};

/// The axis of a finger: a line through two points of the hand, and two places that it was seen to
/// go through.
struct PoseLine {
  std::array<Eigen::Vector3d, 2> hand_m;
  std::array<Eigen::Vector3d, 2> per_spread_m;
  std::array<Eigen::Vector2d, 2> px;
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();  ///< of each point of the hand
  double sigma_px = 1.0;                                    ///< of each place, across the line
  int finger = 0;
};

/// All that a pose rests on.
struct PoseFeatures {
  std::array<PosePoint, kMaxPosePoints> point;
  std::array<PoseLine, kFingerCount> line;
  int point_count = 0, line_count = 0;
  double spread_sigma_rad = 0;  ///< prior of each finger's turn; 0: a rigid hand

  std::span<const PosePoint> points() const {
    return {point.data(), static_cast<std::size_t>(point_count)};
  }
  std::span<const PoseLine> lines() const {
    return {line.data(), static_cast<std::size_t>(line_count)};
  }
  void add(const PosePoint& p) { point[point_count++] = p; }
  void add(const PoseLine& l) { line[line_count++] = l; }
  /// With heights over the hand plane of the opposite sign.
  PoseFeatures mirrored() const;
  bool flat() const;
  double degrees_of_freedom() const { return 2.0 * (point_count + line_count) - 6; }
};

/// A pose and how well it fits.
struct FittedPose {
  Eigen::Isometry3d T_camera_hand = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Zero();        ///< as in PoseEstimate, noise as stated
  Matrix6d noise_covariance = Matrix6d::Zero();  ///< the part from pixel noise
  double deviance = 0;                           ///< squared error in standard deviations, robust
  double chi2 = 0;                               ///< the same, all features at full weight
  double points_chi2 = 0;                        ///< of the points and the spreads alone
  double rms_px = 0;                             ///< as in PoseEstimate
  std::array<double, kFingerCount> spread_rad{};
};

/// Displacement of the image of a point: pixel residual (seen - projected) and its derivative by
/// rotation and translation errors as in PoseEstimate::covariance. False behind the camera.
bool reprojection(const PosePoint& point, const Camera& camera, const Eigen::Isometry3d& T,
                  Eigen::Vector2d& residual_px, Eigen::Matrix<double, 2, 6>& J_pose,
                  Eigen::Matrix<double, 2, 3>& J_hand_m);

/// How far each place of a line was seen to lie beside its image, and the derivatives of that by
/// the pose, as above, and by the finger's spread. `covariance_px2` is theirs. All zero but the
/// covariance where the line points at the eye and has no image. False behind the camera.
bool offset_of_line(const PoseLine& line, const Camera& camera, const Eigen::Isometry3d& T,
                    double spread_rad, Eigen::Vector2d& residual_px,
                    Eigen::Matrix<double, 2, 6>& J_pose, Eigen::Vector2d& J_spread,
                    Eigen::Matrix2d& covariance_px2);

/// The best fit near `start`: Levenberg-Marquardt on SE(3) and the fingers' spreads, with Huber
/// weights for each point and line. Spreads are eliminated finger by finger (Schur complement);
/// what else is uncertain of a point on the hand is no variable, but widens the covariance of its
/// residual. Empty when something comes to lie behind the camera or the pose is not determined.
std::optional<FittedPose> refine(const PoseFeatures& features, const Camera& camera, double huber,
                                 const Eigen::Isometry3d& start);

}  // namespace handyar
