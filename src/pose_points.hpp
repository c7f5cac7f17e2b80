// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "handyar/pose.hpp"
#include "pose_refinement.hpp"

namespace handyar {

/// The seen points that the method uses, with what is not known of their places on the hand. Empty
/// when there are fewer than four, fewer than three tips, or one is not finite.
std::optional<PosePoints> pose_points(const HandObservation& observation, const HandModel& hand,
                                      const PoseConfig& config);

}  // namespace handyar
