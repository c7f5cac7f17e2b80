// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "handyar/camera.hpp"
#include "handyar/stages/align.hpp"
#include "track/tracker_config.hpp"

namespace handyar {

/// How a figure that faces the camera stands, as far as rough fingertips and roots allow: they tell
/// place, size and direction well, tilt badly, and how the fingers are spread as well as a person's
/// rest does. Tilt and abduction have priors, around facing the camera and `expected`.
HandState start_state(const RoughFingers& seen, const HandFigure& figure, const Posture& expected,
                      const Camera& camera, const MotionConfig& motion) noexcept;

/// The other pose in which a plane looks nearly the same: its normal mirrored at the line of sight.
Eigen::Isometry3d other_planar_solution(const Eigen::Isometry3d& T_camera_hand) noexcept;

}  // namespace handyar
