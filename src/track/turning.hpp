// SPDX-License-Identifier: MIT
#pragma once

#include "handyar/stages/align.hpp"

namespace handyar {

/// The other pose in which a plane looks nearly the same: its normal mirrored at the line of sight.
Eigen::Isometry3d other_planar_solution(const Eigen::Isometry3d& T_camera_hand) noexcept;

/// How far a hand would turn through its edge to lie as far on the other side of it, 0 to pi.
double turn_through_edge_rad(const Eigen::Isometry3d& T_camera_hand) noexcept;

/// The hand on the other side of its edge, mirrored in depth, how it moves like how it lies.
HandState beyond_edge(const HandState& state) noexcept;

/// A hand that has turned over shows its other face, with the thumb on the other side: the same
/// solid, its frame turned by half a turn about the fingers. False, and all as it was, where it
/// still shows the same face.
bool turn_over(Appearance& appearance, Eigen::Isometry3d& T_camera_hand) noexcept;

}  // namespace handyar
