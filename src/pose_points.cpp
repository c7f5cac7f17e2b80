// SPDX-License-Identifier: MIT
#include "pose_points.hpp"

#include <cmath>

#include "handyar/hand_shape.hpp"

namespace handyar {
namespace {

bool usable(const ObservedPoint& p) {
  return p.px.allFinite() && std::isfinite(p.sigma_px) && p.sigma_px > 0;
}

}  // namespace

std::optional<PosePoints> pose_points(const HandObservation& observation, const HandModel& hand,
                                      const PoseConfig& config) {
  const bool round = config.method == PoseMethod::points;
  // Five tips and valleys that were not measured cannot tell a turned finger from a turned hand.
  const bool articulated = round && hand.has_valleys;
  const double towards_thumb = hand.layout == Layout::thumb_right ? 1.0 : -1.0;
  const Eigen::Matrix<double, 2, kFingerCount> knuckles = hand.knuckles_m();
  const Eigen::Matrix<double, 3, kFingerCount> directions = hand.directions();
  const Eigen::Matrix<double, 3, kValleyCount> openings = hand.valley_directions();
  const double spread_sigma_rad = articulated ? config.spread_sigma_rad : 0.0;
  const double relief2 = config.relief_sigma_m * config.relief_sigma_m;

  PosePoints points;
  for (int i = 0; i < kFingerCount; ++i) {
    const ObservedPoint& seen = observation.tips[i];
    if (!seen.seen) continue;
    if (!usable(seen)) return std::nullopt;
    PosePoint p{
        .hand_m = hand.tips_m.col(i), .px = seen.px, .sigma_px = seen.sigma_px, .finger = i};
    p.direction = directions.col(i);
    p.radius_m = round ? config.tip_radius_m : 0.0;
    const Eigen::Vector3d sigma_m = hand.tips_sigma_m.col(i);
    const double plane_sigma_m = sigma_m.isZero() ? config.tip_sigma_m : 0.0;
    p.covariance_m2.diagonal() =
        (sigma_m + Eigen::Vector3d(plane_sigma_m, plane_sigma_m, 0)).array().square();
    p.covariance_m2(2, 2) += relief2;
    const Eigen::Vector2d arm = p.hand_m.head<2>() - knuckles.col(i);
    p.per_spread_m << towards_thumb * arm.y(), -towards_thumb * arm.x(), 0;
    p.spread_sigma_rad = spread_sigma_rad;
    p.covariance_m2 +=
        spread_sigma_rad * spread_sigma_rad * p.per_spread_m * p.per_spread_m.transpose();
    points.push_back(p);
  }
  if (points.count < (articulated ? 3 : 4)) return std::nullopt;
  const auto valleys_m = hand.has_valleys ? hand.valleys_m : average_valleys_m(hand);
  const double guess2 =
      hand.has_valleys ? 0.0 : config.average_valley_sigma_m * config.average_valley_sigma_m;
  for (int i = 0; i < kValleyCount && round; ++i) {
    const ObservedPoint& seen = observation.valleys[i];
    if (!seen.seen) continue;
    if (!usable(seen)) return std::nullopt;
    PosePoint p{.hand_m = valleys_m.col(i), .px = seen.px, .sigma_px = seen.sigma_px};
    p.direction = openings.col(i);
    p.radius_m = config.web_radius_m;
    Eigen::Matrix3d shape = Eigen::Vector3d(1, 1, 0).asDiagonal();
    shape +=
        (config.valley_stretch * config.valley_stretch - 1) * p.direction * p.direction.transpose();
    p.covariance_m2 = config.valley_sigma_m * config.valley_sigma_m * shape;
    p.covariance_m2(2, 2) = relief2;
    p.covariance_m2.diagonal().array() += guess2;
    p.wander_m2 = config.valley_wander_m * config.valley_wander_m * shape;
    points.push_back(p);
  }
  if (points.count < 4) return std::nullopt;
  return points;
}

}  // namespace handyar
