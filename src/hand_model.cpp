// SPDX-License-Identifier: MIT
#include "handyar/hand_model.hpp"

#include <algorithm>

namespace handyar {
namespace {

/// Knuckles of an average hand in `thumb_right`, in spans (thumb tip to little fingertip). The
/// thumb's is the one at the wrist, about which it spreads.
const Eigen::Matrix<double, 2, kFingerCount> kAverageKnuckles =
    (Eigen::Matrix<double, 2, kFingerCount>() << 0.12, 0.116, -0.008, -0.13, -0.255,  //
     -0.42, -0.016, -0.04, -0.06, -0.077)
        .finished();

}  // namespace

std::string_view name(Layout layout) noexcept {
  return layout == Layout::thumb_right ? "thumb_right" : "thumb_left";
}

HandModel HandModel::for_layout(Layout wanted) const {
  HandModel m = *this;
  if (wanted == layout) return m;
  m.layout = wanted;
  m.tips_m.row(0) *= -1;
  m.valleys_m.row(0) *= -1;
  m.axis_ends_m.row(0) *= -1;
  m.axis_roots_m.row(0) *= -1;
  for (Eigen::Vector2d& p : m.outline_m) p.x() = -p.x();
  return m;
}

Eigen::Matrix<double, 2, kFingerCount> HandModel::knuckles_m() const noexcept {
  Eigen::Matrix<double, 2, kFingerCount> knuckles = span_m() * kAverageKnuckles;
  if (layout == Layout::thumb_left) knuckles.row(0) *= -1;
  if (!has_valleys) return knuckles;

  const auto valleys = valleys_m.topRows<2>();
  Eigen::Matrix<double, 2, kFingerCount> roots;
  roots.col(2) = 0.5 * (valleys.col(1) + valleys.col(2));
  roots.col(3) = 0.5 * (valleys.col(2) + valleys.col(3));
  roots.col(1) = 2 * valleys.col(1) - roots.col(2);  // index and little have a valley on one side
  roots.col(4) = 2 * valleys.col(3) - roots.col(3);
  for (int i = 1; i < kFingerCount; ++i)
    knuckles.col(i) = roots.col(i) - 0.3 * (tips_m.col(i).head<2>() - roots.col(i));
  return knuckles;
}

Eigen::Matrix<double, 3, kFingerCount> HandModel::directions() const noexcept {
  Eigen::Matrix<double, 3, kFingerCount> d = Eigen::Matrix<double, 3, kFingerCount>::Zero();
  d.topRows<2>() = (tips_m.topRows<2>() - knuckles_m()).colwise().normalized();
  return d;
}

Eigen::Matrix<double, 3, kValleyCount> HandModel::valley_directions() const noexcept {
  const Eigen::Matrix<double, 3, kFingerCount> d = directions();
  return (d.leftCols<kValleyCount>() + d.rightCols<kValleyCount>()).colwise().normalized();
}

Eigen::Vector3d outline_end_m(const Eigen::Vector3d& end_m, const Eigen::Vector3d& direction,
                              double radius_m, const Eigen::Vector3d& eye_m) noexcept {
  const Eigen::Vector3d centre = end_m - radius_m * direction;
  const Eigen::Vector3d ray = (centre - eye_m).normalized();
  const Eigen::Vector3d across = direction - direction.dot(ray) * ray;
  return centre + radius_m / std::max(across.norm(), kEndOn) * across;
}

HandModel average_adult_hand() {
  HandModel m;
  // Shape: a MakeHuman (CC0) adult hand, fingers spread, and the hand the paper's authors shipped
  // with their program (span 179 mm), averaged; size: scaled to the mean adult hand length of
  // 187 mm (ANSUR II 2012: men 193 mm, women 181 mm).
  m.tips_m << 0.0945, 0.0450, 0.0000, -0.0420, -0.0720,  //
      0.0000, 0.0800, 0.0955, 0.0775, 0.0415,            //
      0.0, 0.0, 0.0, 0.0, 0.0;
  // Hands differ, and thumbs are held in many ways: a model as sure of them as a measured one tilts
  // a hand whose thumb stands otherwise until the object on it hovers over the thumb.
  m.tips_sigma_m << 0.006, 0.003, 0.003, 0.003, 0.003,  //
      0.006, 0.003, 0.003, 0.003, 0.003,                //
      0.003, 0.0015, 0.0015, 0.0015, 0.0015;
  m.layout = Layout::thumb_right;
  m.source = HandSource::average_adult;
  return m;
}

}  // namespace handyar
