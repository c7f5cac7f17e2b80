// SPDX-License-Identifier: MIT
#include "track/seen_fingers.hpp"

#include <algorithm>
#include <cmath>

#include "align/hand_view.hpp"

namespace handyar {

RoughFingers rough_fingers(const HandCandidate& candidate) noexcept {
  RoughFingers fingers;
  for (int f = 0; f < kFingerCount; ++f) {
    fingers.tips_px[f] = candidate.tips_px[f].cast<double>();
    fingers.roots_px[f] = candidate.roots_px[f].cast<double>();
  }
  fingers.sigma_px = candidate.tip_sigma_px();
  return fingers;
}

SeenFingers on_hand(const RoughFingers& seen, Appearance appearance, const HandState& state,
                    const Camera& camera) noexcept {
  const Eigen::Isometry3d& T = state.T_camera_hand;
  const PosedFigure posed = posed_figure(appearance, state);
  const auto place = [&](const Eigen::Vector2d& px, const Eigen::Vector3d& of_figure_m) {
    const double depth_m = (T * of_figure_m).z();
    return (T.inverse() * (depth_m * camera.unproject(px).homogeneous())).eval();
  };
  SeenFingers fingers;
  fingers.then = seen;
  for (int f = 0; f < kFingerCount; ++f) {
    fingers.tips_m.col(f) = place(seen.tips_px[f], posed.tips_m.col(f));
    fingers.roots_m.col(f) = place(seen.roots_px[f], posed.centres_m.col(sphere_of(f, 0)));
  }
  return fingers;
}

std::optional<RoughFingers> SeenFingers::in_frame(const Eigen::Isometry3d& T_camera_hand,
                                                  const Camera& camera) const noexcept {
  RoughFingers now;
  double moved_px2 = 0;
  for (int f = 0; f < kFingerCount; ++f) {
    const Eigen::Vector3d tip = T_camera_hand * tips_m.col(f),
                          root = T_camera_hand * roots_m.col(f);
    if (!(std::min(tip.z(), root.z()) > kNearest_m)) return std::nullopt;
    now.tips_px[f] = camera.project(tip);
    now.roots_px[f] = camera.project(root);
    moved_px2 += (now.tips_px[f] - then.tips_px[f]).squaredNorm() / kFingerCount;
  }
  // Their standard deviation grows by this share of how far they have moved. At 0 a hand that
  // tilts fast is lost, since its fingers are held (12 % of the open frames of one clip, 7 at 2).
  constexpr double kBends = 2;
  now.sigma_px = std::hypot(then.sigma_px, kBends * std::sqrt(moved_px2));
  return now;
}

}  // namespace handyar
