// SPDX-License-Identifier: MIT
#include "pose_features.hpp"

#include <cmath>

#include "handyar/hand_shape.hpp"

namespace handyar {
namespace {

bool usable_sigma(double sigma_px) { return std::isfinite(sigma_px) && sigma_px > 0; }

bool usable(const ObservedPoint& p) { return p.px.allFinite() && usable_sigma(p.sigma_px); }
bool usable(const ObservedAxis& a) {
  return a.end_px.allFinite() && a.root_px.allFinite() && usable_sigma(a.sigma_px);
}

/// The hand and the method's view of it.
struct Hand {
  const HandModel& model;
  const PoseConfig& config;
  bool round = config.method != PoseMethod::tips;
  // Five tips and valleys that were not measured cannot tell a turned finger from a turned hand.
  bool articulated = round && model.has_valleys;
  Eigen::Matrix<double, 2, kFingerCount> knuckles = model.knuckles_m();
  Eigen::Matrix<double, 3, kFingerCount> directions = model.directions();
  Eigen::Matrix<double, 3, kValleyCount> openings = model.valley_directions();

  /// How a point of a finger moves where the finger turns towards the thumb.
  Eigen::Vector3d per_spread_m(int finger, const Eigen::Vector3d& p_m) const {
    const double towards_thumb = model.layout == Layout::thumb_right ? 1.0 : -1.0;
    const Eigen::Vector2d arm = p_m.head<2>() - knuckles.col(finger);
    return {towards_thumb * arm.y(), -towards_thumb * arm.x(), 0};
  }

  PosePoint tip(int finger, const ObservedPoint& seen) const {
    PosePoint p{.hand_m = model.tips_m.col(finger),
                .px = seen.px,
                .sigma_px = seen.sigma_px,
                .finger = finger};
    p.direction = directions.col(finger);
    p.radius_m = round ? config.tip_radius_m : 0.0;
    const Eigen::Vector3d sigma_m = model.tips_sigma_m.col(finger);
    const double plane_sigma_m = sigma_m.isZero() ? config.tip_sigma_m : 0.0;
    p.covariance_m2.diagonal() =
        (sigma_m + Eigen::Vector3d(plane_sigma_m, plane_sigma_m, 0)).array().square();
    p.covariance_m2(2, 2) += config.relief_sigma_m * config.relief_sigma_m;
    if (articulated)
      p.covariance_m2 +=
          config.tip_along_m * config.tip_along_m * p.direction * p.direction.transpose();
    p.per_spread_m = per_spread_m(finger, p.hand_m);
    return p;
  }

  PosePoint valley(int k, const Eigen::Vector3d& hand_m, const ObservedPoint& seen) const {
    PosePoint p{.hand_m = hand_m, .px = seen.px, .sigma_px = seen.sigma_px};
    p.direction = openings.col(k);
    p.radius_m = config.web_radius_m;
    Eigen::Matrix3d shape = Eigen::Vector3d(1, 1, 0).asDiagonal();
    shape +=
        (config.valley_stretch * config.valley_stretch - 1) * p.direction * p.direction.transpose();
    p.covariance_m2 = config.valley_sigma_m * config.valley_sigma_m * shape;
    p.covariance_m2(2, 2) = config.relief_sigma_m * config.relief_sigma_m;
    if (!model.has_valleys)
      p.covariance_m2.diagonal().array() +=
          config.average_valley_sigma_m * config.average_valley_sigma_m;
    p.wander_m2 = config.valley_wander_m * config.valley_wander_m * shape;
    return p;
  }

  PoseLine axis(int finger, const ObservedAxis& seen) const {
    PoseLine l;
    l.hand_m = {model.axis_ends_m.col(finger), model.axis_roots_m.col(finger)};
    l.px = {seen.end_px, seen.root_px};
    l.sigma_px = seen.sigma_px;
    for (int k = 0; k < 2; ++k) l.per_spread_m[k] = per_spread_m(finger, l.hand_m[k]);
    const Eigen::Vector3d sigma_m(config.axis_sigma_m, config.axis_sigma_m, config.relief_sigma_m);
    l.covariance_m2.diagonal() = sigma_m.array().square();
    l.finger = finger;
    return l;
  }
};

}  // namespace

std::optional<PoseFeatures> pose_features(const HandObservation& observation, const HandModel& hand,
                                          const PoseConfig& config) {
  const Hand h{hand, config};
  PoseFeatures features;
  features.spread_sigma_rad = h.articulated ? config.spread_sigma_rad : 0.0;
  for (int i = 0; i < kFingerCount; ++i) {
    const ObservedPoint& seen = observation.tips[i];
    if (!seen.seen) continue;
    if (!usable(seen)) return std::nullopt;
    features.add(h.tip(i, seen));
  }
  if (features.point_count < (h.articulated ? 3 : 4)) return std::nullopt;
  const auto valleys_m = hand.has_valleys ? hand.valleys_m : average_valleys_m(hand);
  for (int i = 0; i < kValleyCount && h.round; ++i) {
    const ObservedPoint& seen = observation.valleys[i];
    if (!seen.seen) continue;
    if (!usable(seen)) return std::nullopt;
    features.add(h.valley(i, valleys_m.col(i), seen));
  }
  if (features.point_count < 4) return std::nullopt;
  if (config.method != PoseMethod::outline || !hand.has_axes) return features;
  for (int i = 0; i < kFingerCount; ++i) {
    const ObservedAxis& seen = observation.axes[i];
    if (!seen.seen) continue;
    if (!usable(seen)) return std::nullopt;
    features.add(h.axis(i, seen));
  }
  return features;
}

}  // namespace handyar
