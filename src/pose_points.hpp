// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "handyar/pose.hpp"
#include "pose_refinement.hpp"

namespace handyar {

/// Where each finger turns when the fingers spread, in the hand plane (metres): three tenths of
/// its free length behind its root between the valleys, or by an average hand's proportions
/// where the model has no valleys.
Eigen::Matrix<double, 2, kFingerCount> knuckles_m(const HandModel& hand);

/// The seen points that the method uses, with what is not known of their places on the hand. Empty
/// when there are fewer than four, fewer than three tips, or one is not finite.
std::optional<PosePoints> pose_points(const HandObservation& observation, const HandModel& hand,
                                      const PoseConfig& config);

}  // namespace handyar
