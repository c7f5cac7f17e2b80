// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "handyar/calibration/view.hpp"

namespace handyar {

/// Sets the axes of the fingers of a hand at rest (HandModel::axis_ends_m, axis_roots_m), from
/// where the views `used` show them and the hand's pose in each of these. `hand` has its tips and
/// valleys already. Leaves it without axes when one was seen too seldom.
void triangulate_axes(std::span<const CalibrationView> views, const std::vector<int>& used,
                      std::span<const Eigen::Isometry3d> T_camera_hand, const Camera& camera,
                      HandModel& hand);

}  // namespace handyar
