// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "handyar/hand_model.hpp"

namespace handyar {

/// Five fingertips and, where known, the four webs, in some frame (metres).
struct HandPoints {
  Eigen::Matrix<double, 3, kFingerCount> tips_m;
  bool has_webs = false;
  Eigen::Matrix<double, 3, kValleyCount> webs_m = Eigen::Matrix<double, 3, kValleyCount>::Zero();
};

/// The hand frame (HandModel, paper Figure 5) of these points, as the transform from the hand frame
/// to theirs. z is normal to the plane nearest to the tips, on the side of `outwards`, which points
/// out of the visible face; the middle finger's direction is taken from
/// the webs at its root to its tip or, without them, from the best fit of the average hand.
Eigen::Isometry3d hand_frame(const HandPoints& points, const Eigen::Vector3d& outwards);

/// Best fit of the average adult hand to tips in the hand plane (2x5): scale, turn and shift that
/// lay it on them, in the layout that fits better.
struct AverageHandFit {
  Layout layout = Layout::thumb_right;
  double scale = 1;
  double turn_rad = 0;
};
AverageHandFit fit_average_hand(const Eigen::Matrix<double, 2, kFingerCount>& tips_m);

/// The points in the hand frame as a hand model: tips and layout are set.
HandModel hand_model(const HandPoints& points, const Eigen::Isometry3d& T_points_hand);

}  // namespace handyar
