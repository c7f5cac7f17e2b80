// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>

#include "handyar/camera.hpp"
#include "handyar/hand_model.hpp"

namespace handyar {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// What the pose rests on.
enum class PoseMethod : std::uint8_t {
  tips,    ///< the fingertips, as a rigid body (the paper)
  points,  ///< round tips, and valleys; each finger may have turned in the hand plane since
           ///< calibration (hand models without valleys: of a rigid hand, with an average's
           ///< valleys)
  outline  ///< and the fingers' sides, whose middle is the finger's axis; hand models without axes:
           ///< as `points`
};

/// What is not known of a hand, as standard deviations.
struct PoseConfig {
  PoseMethod method = PoseMethod::outline;
  double spread_sigma_rad = 0.042;     ///< turn of a finger about its knuckle; not `tips`
  double tip_radius_m = kTipRadius_m;  ///< of the fingers' round ends; not `tips`
  double web_radius_m = kWebRadius_m;  ///< of the web between them, from back to palm
  double tip_sigma_m = 0.001;      ///< of the ends of fingers in the hand plane, where the model's
                                   ///< tips_sigma_m says nothing
  double tip_along_m = 0.001;      ///< light and nails move them along their fingers; not where
                                   ///< valleys are those of an average hand: these know less
  double valley_sigma_m = 0.001;   ///< valleys are skin: how far they move in the hand plane
  double valley_wander_m = 0.020;  ///< and by how much more where the hand is seen edge on
  double valley_stretch = 5;       ///< times as far along the fingers: valleys are narrow, what
                                   ///< moves their sides a little moves their ends by more
  double average_valley_sigma_m = 0.004;  ///< of valleys that were not measured
  double axis_sigma_m = 0.0020;           ///< of both ends of a finger's axis, across
  double relief_sigma_m = 0.001;  ///< height of each point over the hand plane against the model's
  double huber = 1.0;             ///< points more standard deviations off than this weigh less
};

/// A tip or a valley as one frame shows it.
struct ObservedPoint {
  Eigen::Vector2d px = Eigen::Vector2d::Zero();
  double sigma_px = 1.0;  ///< standard deviation of each coordinate, > 0
  bool seen = false;      ///< false: the rest is meaningless
};
/// The axis of a finger as one frame shows it: two places that it goes through.
struct ObservedAxis {
  Eigen::Vector2d end_px = Eigen::Vector2d::Zero(), root_px = Eigen::Vector2d::Zero();
  double sigma_px = 1.0;  ///< standard deviation of each across the finger, > 0
  bool seen = false;      ///< false: the rest is meaningless
};
struct HandObservation {
  std::array<ObservedPoint, kFingerCount> tips;
  std::array<ObservedPoint, kValleyCount> valleys;  ///< not used by PoseMethod::tips
  std::array<ObservedAxis, kFingerCount> axes;      ///< used by PoseMethod::outline only
};

/// A pose expected before the frame was looked at; covariance as in PoseEstimate.
struct PosePrediction {
  Eigen::Isometry3d T_camera_hand = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Identity();
};

/// What is known beforehand. It decides between hypotheses; the estimate itself is the frame's
/// alone, so that a filter can use it as an independent measurement.
struct PosePrior {
  std::optional<PosePrediction> prediction;

  /// Probability that heights over the hand plane are the model's and not mirrored (z against -z):
  /// they are mirrored when the palm is seen with a model of the back, or the reverse. Between 0
  /// and 1 the estimate is the mean of both cases and its covariance says so.
  double relief_probability = 1.0;
};

/// Camera pose relative to the hand, from one frame (paper 2.5).
struct PoseEstimate {
  Eigen::Isometry3d T_camera_hand = Eigen::Isometry3d::Identity();

  /// Order: rotation (rad), translation (m). The rotation error is on the left, in camera axes:
  /// R_true = exp([w]x) R, t_true = t + d. Shrinks and grows with how well the points agree with
  /// the model, and grows with the probability of the other hypotheses.
  Matrix6d covariance = Matrix6d::Zero();

  /// The part of `covariance` that comes from pixel noise and is new in each frame; the rest stays
  /// as long as hand and view do, and no filter can average it out.
  Matrix6d noise_covariance = Matrix6d::Zero();

  /// Distance between seen and reprojected fingertips in the calibrated posture, weighted by
  /// 1 / sigma_px^2; without the worst one where seven points or more are seen, valleys among them;
  /// by the better of both reliefs where both were tried.
  double rms_px = std::numeric_limits<double>::quiet_NaN();

  /// Squared error in standard deviations per degree of freedom: about 1 when noise and model are
  /// as stated, much more when something is wrong.
  double reduced_chi2 = 0.0;

  /// rms_px of this solution over that of the other planar one: near 0 sure, near 1 ambiguous, more
  /// when the prediction decided; 0 when there is no other.
  double ambiguity = 0.0;

  /// Evidence of this frame alone for this solution against the other planar one: log of the
  /// likelihood ratio, for the tracker to add up; negative where the prediction decided against it,
  /// 0 when there is no other.
  double planar_log_ratio = 0.0;

  /// Turn of each finger in the hand plane against the calibrated posture, towards the thumb
  /// positive; zero for methods that do not estimate it.
  std::array<double, kFingerCount> spread_rad{};

  /// Evidence of this frame alone for the model's relief against the mirrored one: log of the
  /// likelihood ratio, for the tracker to add up; 0 when only one was tried.
  double relief_log_ratio = 0.0;

  int points_used = 0;
  int axes_used = 0;
};

/// Pose from at least four points of which three are tips, or four where the hand model has no
/// valleys (paper 2.5). `hand` is in the layout that is seen. Empty when there are too few points,
/// when they lie on a line, when something seen is not finite, or when no pose puts the visible
/// face before the camera. Takes no memory.
std::optional<PoseEstimate> estimate_pose(const HandObservation& observation, const HandModel& hand,
                                          const Camera& camera, const PoseConfig& config = {},
                                          const PosePrior& prior = {}) noexcept;

/// Root mean square standard deviation of rotation (rad) over the three axes.
double sigma_rotation_rad(const Matrix6d& covariance) noexcept;
/// Root mean square standard deviation of translation (m) over the three axes.
double sigma_translation_m(const Matrix6d& covariance) noexcept;

}  // namespace handyar
