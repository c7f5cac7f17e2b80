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

/// Turns the fingers of a hand that begins in the palm plane to where their tips are seen, as far
/// as lively fingers are likely to turn: one that begins beside the finger in the picture takes the
/// colours of what is there for its own.
void spread_as_seen(const RoughFingers& seen, Appearance appearance, const Camera& camera,
                    HandState& state) noexcept;

}  // namespace handyar
