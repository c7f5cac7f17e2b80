// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "look.hpp"

namespace handyar::world {

/// The map in a picture of which nothing is known: corners alike by their descriptors, a pose that
/// enough of them agree on, and then a look whether the map is there. It is to be confirmed in the
/// next picture.
std::optional<Seen> recognise(const WorldMap& map, const Picture& picture, const cv::Mat& free,
                              const Camera& camera);

}  // namespace handyar::world
