// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "handyar/camera.hpp"
#include "handyar/stages/align.hpp"
#include "track/tracker_config.hpp"

namespace handyar {

/// How a figure that faces the camera stands, as far as rough fingertips and roots allow: they tell
/// place, size, direction and where the thumb is well, tilt badly. Tilt and the thumb's abduction
/// have priors, around facing the camera and `expected`; the other fingers stay as expected.
HandState start_state(const RoughFingers& seen, const HandFigure& figure, const Posture& expected,
                      const Camera& camera, const MotionConfig& motion) noexcept;

/// The other pose in which a plane looks nearly the same: its normal mirrored at the line of sight.
Eigen::Isometry3d other_planar_solution(const Eigen::Isometry3d& T_camera_hand) noexcept;

}  // namespace handyar
