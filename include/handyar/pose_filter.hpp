// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <optional>

#include "handyar/api.h"
#include "handyar/pose.hpp"

namespace handyar {

/// Accelerations bound how hard the hand speeds up; how hard it does at the moment, from almost not
/// at all upwards, the filter finds out by itself.
struct PoseFilterConfig {
  double acceleration_m_s2 = 4.0;     ///< how hard a hand is expected to speed up; lower: smoother
  double acceleration_rad_s2 = 40.0;  ///< the same for turning
  double gate_probability = 0.9999;   ///< starts anew from what is less likely than 1 - this
  double max_coast_s = 0.25;          ///< without measurements for longer: no prediction
  bool enabled = true;                ///< false: the raw pose passes through unfiltered
};

/// Position, orientation and their velocities as a Gaussian: the orientation is a rotation, its
/// error a rotation vector in camera axes. Errors are ordered rotation, translation, angular
/// velocity, velocity.
struct MotionState {
  using Vector12d = Eigen::Matrix<double, 12, 1>;
  using Matrix12d = Eigen::Matrix<double, 12, 12>;

  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< sign kept from frame to frame
  Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_velocity_rad_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Matrix12d covariance = Matrix12d::Zero();

  /// Error of `other` against this.
  Vector12d difference(const MotionState& other) const noexcept;
  /// Moves by an error.
  void correct(const Vector12d& error) noexcept;
  /// Constant velocities for `dt_s`, disturbed by white accelerations of the given spectral
  /// densities (m^2/s^3, rad^2/s^3).
  void advance(double dt_s, double density_m, double density_rad) noexcept;
  /// Velocities become zero; the pose stays.
  void rest() noexcept;
};

/// Kalman filter on position, orientation and their velocities (paper 2.5): an error-state filter
/// for each of a few levels of acceleration, from still to moving, combined by how well each
/// foretells the measurements (interacting multiple models, Blom and Bar-Shalom 1988). So it holds
/// still when the hand does and does not lag when it moves.
class HANDYAR_API PoseFilter {
 public:
  explicit PoseFilter(const PoseFilterConfig& config = {}) noexcept;

  /// Forgets everything; the next measurement starts anew.
  void reset() noexcept;

  /// Takes a measurement made at `time_s` (after the previous one). Where no hand moves so that it
  /// would come there, it starts anew from it. False, and without effect, when a value is not
  /// finite or time does not increase.
  bool update(double time_s, const PoseEstimate& measurement) noexcept;

  /// State carried to `time_s`; empty before the first measurement and when the last one is too
  /// long ago.
  [[nodiscard]] std::optional<FilteredPose> predict(double time_s) const noexcept;

 private:
  static constexpr int kLevels = 4;

  struct Level {
    MotionState state;
    double probability = 1.0 / kLevels;
  };

  HANDYAR_INTERNAL void start(double time_s, const PoseEstimate& measurement) noexcept;
  HANDYAR_INTERNAL void mix(double dt_s) noexcept;
  HANDYAR_INTERNAL MotionState combined() const noexcept;

  PoseFilterConfig config_;
  double gate_ = 0;  ///< of the squared Mahalanobis distance
  bool running_ = false;
  double time_s_ = 0;  ///< of the states
  std::array<Level, kLevels> levels_;
  Matrix6d lasting_ = Matrix6d::Zero();  ///< covariance of what does not change between frames
};

}  // namespace handyar
