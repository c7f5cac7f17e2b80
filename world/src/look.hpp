// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "matching.hpp"
#include "resection.hpp"

namespace handyar::world {

/// What is asked of a pose: so many points that agree, and so great a share of those that should be
/// seen.
struct Belief {
  std::size_t inliers;
  double share;
};

/// Where things repeat, as the keys of a keyboard do, more than half of the points may agree on a
/// pose that is one key off. On tabletops of which the truth is known no right pose had less than
/// 0.71 of them.
inline constexpr double kShareOfRight = 0.67;

/// The map as a picture shows it.
struct Seen {
  Resection pose;
  Matches matches;
  std::size_t reference = 0;  ///< the keyframe looked for
};

inline constexpr std::size_t kMostPoints = 100;  ///< looked for in a picture

/// The keyframe of which most is in view, from most nearly the same side.
std::size_t reference_for(const WorldMap& map, const View& view);

/// Looks for the points of that keyframe, each near where `guess` puts it, and makes their pose;
/// empty when it is not believed.
std::optional<Seen> look(const WorldMap& map, const Picture& picture, const cv::Mat& free,
                         const View& guess, const Belief& belief);

/// The same in two steps, for a guess that may be farther off.
std::optional<Seen> look_twice(const WorldMap& map, const Picture& picture, const cv::Mat& free,
                               const View& guess, const Belief& belief);

}  // namespace handyar::world
