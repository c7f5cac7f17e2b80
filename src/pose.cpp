// SPDX-License-Identifier: MIT
#include "handyar/pose.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "handyar/planar_pose.hpp"
#include "pose_features.hpp"
#include "pose_refinement.hpp"
#include "so3.hpp"

namespace handyar {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;

/// Up to two poses that explain what was seen, the more probable first.
struct Hypotheses {
  std::array<FittedPose, 2> pose;
  std::array<double, 2> frame_deviance{};  ///< -2 log of the likelihood alone
  std::array<double, 2> deviance{};        ///< -2 log of likelihood times prior
  int count = 0;
  double degrees_of_freedom = 0;

  double reduced_chi2() const { return pose[0].chi2 / degrees_of_freedom; }

  void push_back(const FittedPose& p, double by_frame, double by_prior) {
    const double d = by_frame + by_prior;
    if (count == 2 && d >= deviance[1]) return;
    const int last = count < 2 ? count++ : 1;
    pose[last] = p;
    frame_deviance[last] = by_frame;
    deviance[last] = d;
    if (count == 2 && deviance[1] < deviance[0]) {
      std::swap(pose[0], pose[1]);
      std::swap(frame_deviance[0], frame_deviance[1]);
      std::swap(deviance[0], deviance[1]);
    }
  }
};

/// Error of b against a, as in PoseEstimate::covariance.
Vector6d difference(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  Vector6d d;
  d << so3::log(Eigen::Matrix3d(b.linear() * a.linear().transpose())),
      b.translation() - a.translation();
  return d;
}

/// -2 log of the prior of a pose. The tails are those of Student's t with ten degrees of freedom:
/// a prediction can be plainly wrong, and then has no say between two poses far from it.
double prior_deviance(const FittedPose& pose, const PosePrior& prior) {
  if (!prior.prediction) return 0;
  constexpr double kTail = 10;
  const Vector6d d = difference(prior.prediction->T_camera_hand, pose.T_camera_hand);
  const Matrix6d S = prior.prediction->covariance + pose.covariance;
  const double d2 = d.dot(S.ldlt().solve(d));
  return std::isfinite(d2) ? (kTail + 6) * std::log1p(d2 / kTail) : 0;
}

/// The visible face looks at the camera; fingers seen flatter than this cannot be told apart.
bool faces_camera(const Eigen::Isometry3d& T) {
  const double kMinCos = std::cos(80 * std::numbers::pi / 180);
  return -T.linear().col(2).dot(T.translation()) > kMinCos * T.translation().norm();
}

/// Turned by less than `within` radians and moved by less than that share of the distance.
bool near(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double within) {
  const Vector6d d = difference(a, b);
  return d.head<3>().norm() < within && d.tail<3>().norm() < within * a.translation().norm();
}

/// Different poses in the neighbourhood of which what was seen is explained.
class Candidates {
 public:
  Candidates(const PoseFeatures& features, const Camera& camera, double huber)
      : features_(features), camera_(camera), huber_(huber) {}

  /// Refines from `start`; keeps the result unless it is known already.
  void add(const Eigen::Isometry3d& start) {
    constexpr double kSame = 1e-3;
    if (!faces_camera(start)) return;
    const std::optional<FittedPose> fit = refine(features_, camera_, huber_, start);
    if (fit && faces_camera(fit->T_camera_hand) && !knows(fit->T_camera_hand, kSame))
      fits_[count_++] = *fit;
  }

  /// Some result lies so near that refining from here would give it again.
  bool knows_basin_of(const Eigen::Isometry3d& start) const {
    constexpr double kBasin = 0.05;
    return knows(start, kBasin);
  }

  const FittedPose* begin() const { return fits_.data(); }
  const FittedPose* end() const { return fits_.data() + count_; }

 private:
  bool knows(const Eigen::Isometry3d& T, double within) const {
    return std::any_of(begin(), end(),
                       [&](const FittedPose& f) { return near(f.T_camera_hand, T, within); });
  }

  const PoseFeatures& features_;
  const Camera& camera_;
  double huber_;
  std::array<FittedPose, 3> fits_;
  int count_ = 0;
};

/// Refines from both planar solutions and the prediction, keeps the different results.
Hypotheses solve(const PoseFeatures& features, const Camera& camera, double huber,
                 const PosePrior& prior) {
  Hypotheses result;
  result.degrees_of_freedom = features.degrees_of_freedom();
  std::array<Eigen::Vector2d, kMaxPosePoints> plane_m, normalised;
  const std::size_t n = features.points().size();
  for (std::size_t i = 0; i < n; ++i) {
    plane_m[i] = features.point[i].hand_m.head<2>();
    normalised[i] = camera.unproject(features.point[i].px);
  }
  const auto planar = solve_planar({plane_m.data(), n}, {normalised.data(), n});
  if (!planar) return result;

  Candidates candidates(features, camera, huber);
  for (const PlanarPose& p : *planar) candidates.add(p.T_camera_plane);
  if (prior.prediction && !candidates.knows_basin_of(prior.prediction->T_camera_hand))
    candidates.add(prior.prediction->T_camera_hand);

  // Where even the best fits badly, the noise is larger than stated and residuals decide less.
  double inflation = std::numeric_limits<double>::infinity();
  for (const FittedPose& fit : candidates)
    inflation = std::min(inflation, std::max(1.0, fit.chi2 / result.degrees_of_freedom));
  for (const FittedPose& fit : candidates)
    result.push_back(fit, fit.deviance / inflation, prior_deviance(fit, prior));
  return result;
}

/// How much better or worse than stated the points agree with the model, as a factor of its
/// covariance. Few points tell it, so it starts from what is stated, as if that were the size of so
/// many residuals more; and the errors of a hand's points are alike, so they disagree by less than
/// they are off. Both ends of a line err alike even more and tell nothing.
double model_scale(const FittedPose& fit, const PoseFeatures& features) {
  constexpr double kAsStated = 3, kAlike = 4;
  return (kAsStated + kAlike * fit.points_chi2) / (kAsStated + 2.0 * features.point_count - 6);
}

/// The size of a hand is known to this share, and with it the distance: no disagreement shows it.
constexpr double kScaleSigma = 0.006;

PoseEstimate summarise(const Hypotheses& h, const PoseFeatures& features) {
  const FittedPose& best = h.pose[0];
  PoseEstimate e;
  e.T_camera_hand = best.T_camera_hand;
  e.rms_px = best.rms_px;
  e.reduced_chi2 = h.reduced_chi2();
  e.points_used = features.point_count;
  e.axes_used = features.line_count;
  e.spread_rad = best.spread_rad;
  e.noise_covariance = best.noise_covariance * std::max(1.0, e.reduced_chi2);
  const Eigen::Vector3d scale_m = kScaleSigma * best.T_camera_hand.translation();
  e.covariance =
      e.noise_covariance + model_scale(best, features) * (best.covariance - best.noise_covariance);
  e.covariance.bottomRightCorner<3, 3>() += scale_m * scale_m.transpose();
  if (h.count == 2) {
    e.ambiguity = best.rms_px / std::max(h.pose[1].rms_px, 1e-12);
    e.planar_log_ratio = 0.5 * (h.frame_deviance[1] - h.frame_deviance[0]);
    const double probability = 1 / (1 + std::exp(0.5 * (h.deviance[1] - h.deviance[0])));
    const Vector6d d = difference(best.T_camera_hand, h.pose[1].T_camera_hand);
    const Matrix6d ambiguous = probability * d * d.transpose();
    e.covariance += ambiguous;
    e.noise_covariance += ambiguous;  // the noise decides which of the two it is
  }
  return e;
}

/// Mean and covariance of two estimates of which one is right.
PoseEstimate mixture(const PoseEstimate& a, const PoseEstimate& b, double probability_a) {
  PoseEstimate e = probability_a >= 0.5 ? a : b;
  const double q = 1 - probability_a;
  const Vector6d d = difference(a.T_camera_hand, b.T_camera_hand);
  e.T_camera_hand = a.T_camera_hand;
  e.T_camera_hand.linear() =
      (so3::exp(q * d.head<3>()) * Eigen::Quaterniond(a.T_camera_hand.linear())).matrix();
  e.T_camera_hand.translation() += q * d.tail<3>();
  e.covariance =
      probability_a * a.covariance + q * b.covariance + probability_a * q * d * d.transpose();
  e.noise_covariance = probability_a * a.noise_covariance + q * b.noise_covariance;
  e.rms_px = std::min(a.rms_px, b.rms_px);  // while it is not known which, either may explain
  return e;
}

}  // namespace

std::optional<PoseEstimate> estimate_pose(const HandObservation& observation, const HandModel& hand,
                                          const Camera& camera, const PoseConfig& config,
                                          const PosePrior& prior) noexcept {
  std::optional<PoseFeatures> features = pose_features(observation, hand, config);
  if (!features) return std::nullopt;
  PoseFeatures mirrored = features->mirrored();

  const double p_model = std::clamp(prior.relief_probability, 0.0, 1.0);
  const bool flat = features->flat();
  std::optional<PoseEstimate> by_model, by_mirrored;
  double deviance_model = 0, deviance_mirrored = 0;
  if (p_model > 0 || flat) {
    const Hypotheses h = solve(*features, camera, config.huber, prior);
    if (h.count > 0) by_model = summarise(h, *features);
    if (h.count > 0) deviance_model = h.pose[0].deviance;
  }
  if (p_model < 1 && !flat) {
    const Hypotheses h = solve(mirrored, camera, config.huber, prior);
    if (h.count > 0) by_mirrored = summarise(h, mirrored);
    if (h.count > 0) deviance_mirrored = h.pose[0].deviance;
  }
  if (!by_model) return by_mirrored;
  if (!by_mirrored) return by_model;
  PoseEstimate e = mixture(*by_model, *by_mirrored, p_model);
  const double worst = std::max({1.0, by_model->reduced_chi2, by_mirrored->reduced_chi2});
  e.relief_log_ratio = 0.5 * (deviance_mirrored - deviance_model) / worst;
  return e;
}

double sigma_rotation_rad(const Matrix6d& covariance) noexcept {
  return std::sqrt(covariance.topLeftCorner<3, 3>().trace() / 3);
}

double sigma_translation_m(const Matrix6d& covariance) noexcept {
  return std::sqrt(covariance.bottomRightCorner<3, 3>().trace() / 3);
}

}  // namespace handyar
