// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "handyar/calibration/view.hpp"

namespace handyar {

/// Outline of the hand in its own plane (x, y of the hand frame, metres): the closed contour of the
/// hand region, carried to the plane z = 0 and averaged over the most frontal views, cut across the
/// wrist where it is narrowest. Begins at the wrist on the thumb's side, runs over the fingertips
/// and ends at the wrist on the other side; neighbouring points are about 2 mm apart. Empty without
/// contours.
std::vector<Eigen::Vector2d> measure_outline(std::span<const CalibrationView> views,
                                             const std::vector<int>& used,
                                             std::span<const Eigen::Isometry3d> T_camera_board,
                                             const Camera& camera,
                                             const Eigen::Isometry3d& T_board_hand,
                                             const HandModel& hand);

}  // namespace handyar
