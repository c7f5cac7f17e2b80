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

}  // namespace handyar
