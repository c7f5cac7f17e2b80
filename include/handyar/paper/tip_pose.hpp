// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <optional>

#include "handyar/camera.hpp"
#include "handyar/hand_model.hpp"
#include "handyar/pose.hpp"

namespace handyar::paper {

/// Fingertips as a frame shows them; empty: not seen.
using SeenTips = std::array<std::optional<Eigen::Vector2d>, kFingerCount>;

/// Camera pose from at least four fingertips as a rigid body (paper 2.5): both planar solutions,
/// refined on the reprojection error; `expected`, where there is one, decides between solutions
/// that fit about as well. `hand` is in the layout that is seen; `sigma_px` is a fingertip's error.
/// Empty when there are too few, when they lie on a line, or when no pose explains them.
std::optional<PoseEstimate> pose_from_tips(
    const SeenTips& tips, const HandModel& hand, const Camera& camera, double sigma_px = 1.0,
    const std::optional<Eigen::Isometry3d>& expected = {}) noexcept;

}  // namespace handyar::paper
