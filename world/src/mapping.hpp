// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "handyar/world/world_map.hpp"
#include "handyar/world/world_tracker.hpp"

namespace handyar::world {

/// What the tracker hands over when the view has changed.
struct NewView {
  cv::Mat grey, free;
  Eigen::Isometry3d T_camera_world;
  std::vector<Observation> seen;
  std::vector<int> tried, found;  ///< for each point of the map, in how many frames
};

/// The map of one picture, in which the hand lies on its surroundings: its corners on the plane
/// under the hand. Empty when there are too few.
std::optional<WorldMap> first_map(const cv::Mat& grey, const cv::Mat& free, const Camera& camera,
                                  const HandInWorld& hand);

/// The map with one keyframe more: points that are not found again go, new ones are triangulated,
/// and what is near is adjusted together.
WorldMap extended(WorldMap map, const NewView& view);

}  // namespace handyar::world
