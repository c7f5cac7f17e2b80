// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

#include "handyar/pose.hpp"

namespace handyar {

/// Two settings a person can understand; both are physical.
struct PoseFilterConfig {
  double acceleration_m_s2 = 4.0;     ///< how hard a hand is expected to speed up; lower: stiller
  double acceleration_rad_s2 = 40.0;  ///< the same for turning
  double gate_probability = 0.9999;   ///< a measurement less likely than 1 - this is an outlier
  double max_coast_s = 0.25;          ///< without accepted measurements for longer: no prediction
  bool enabled = true;                ///< false: the raw pose passes through unfiltered
};

/// A filtered pose with its velocities, at a stated time.
struct FilteredPose {
  double time_s = 0;
  Eigen::Isometry3d T_camera_hand = Eigen::Isometry3d::Identity();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_velocity_rad_s = Eigen::Vector3d::Zero();  ///< in camera axes
  Matrix6d covariance = Matrix6d::Zero();                            ///< as in PoseEstimate
};

/// Kalman filter on position, orientation and their velocities (paper 2.5), as an error-state
/// filter: the orientation is a rotation, its error a rotation vector in camera axes.
class PoseFilter {
 public:
  explicit PoseFilter(const PoseFilterConfig& config = {}) : config_(config) {}

  /// Forgets everything; the next measurement starts anew.
  void reset() noexcept;

  /// Takes a measurement made at `time_s` (after the previous one). Returns false when the gate
  /// refused it as an outlier; several refusals in a row that agree with each other start the
  /// filter anew.
  bool update(double time_s, const PoseEstimate& measurement) noexcept;

  /// State carried forward to `time_s`; empty before the first measurement and when the last
  /// accepted one is too long ago.
  std::optional<FilteredPose> predict(double time_s) const noexcept;

 private:
  PoseFilterConfig config_;
};

}  // namespace handyar
