// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "handyar/camera.hpp"
#include "handyar/stages/align.hpp"

namespace handyar {

/// The pose of a hand that faces the camera, as far as its rough fingertips and roots allow: they
/// tell place, size and direction well, tilt badly, so tilt has a prior of `tilt_sigma_rad`.
Eigen::Isometry3d start_pose(const RoughFingers& seen, const PosedFigure& hand,
                             const Camera& camera, double tilt_sigma_rad) noexcept;

/// The other pose in which a plane looks nearly the same: its normal mirrored at the line of sight.
Eigen::Isometry3d other_planar_solution(const Eigen::Isometry3d& T_camera_hand) noexcept;

/// A hand that is seen from its edge turned through it, to as far on the other side.
Eigen::Isometry3d beyond_edge(const Eigen::Isometry3d& T_camera_hand) noexcept;

}  // namespace handyar
