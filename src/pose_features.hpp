// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "handyar/pose.hpp"
#include "pose_refinement.hpp"

namespace handyar {

/// What was seen and the method uses, with what is not known of its place on the hand. Empty when
/// there are fewer than four points, fewer than three tips, or something is not finite.
std::optional<PoseFeatures> pose_features(const HandObservation& observation, const HandModel& hand,
                                          const PoseConfig& config);

}  // namespace handyar
