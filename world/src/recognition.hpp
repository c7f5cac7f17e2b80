// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "handyar/world/world_map.hpp"
#include "picture.hpp"

namespace handyar::world {

/// A pose in which a picture that nothing is known of may show the map: corners alike by their
/// descriptors, and enough of them in agreement. It is a guess, to be confirmed by looking.
std::optional<Eigen::Isometry3d> recognise(const WorldMap& map, const Picture& picture,
                                           const cv::Mat& free, const Camera& camera);

}  // namespace handyar::world
