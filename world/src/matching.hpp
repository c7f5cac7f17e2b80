// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "handyar/world/world_map.hpp"
#include "picture.hpp"

namespace handyar::world {

/// A picture with the camera's pose in the world, be it known or guessed.
struct View {
  const Camera& camera;
  const Eigen::Isometry3d& T_camera_world;
};

/// Points that should be seen in a picture, and those of them that were.
struct Matches {
  std::vector<int> expected;      ///< points of the map
  std::vector<Observation> seen;  ///< where they are
};

/// Where in a picture the points are that a keyframe shows. The keyframe is laid over the picture
/// as the ground would look from `view`, so that patches look alike although the camera has moved;
/// each point is then found by optical flow, at most `radius_px` from where `view` puts it, and
/// must look the same. Points outside of `free` (255; empty: all is free) are not expected. At most
/// `most` points are looked for, spread over the keyframe.
Matches find_in_picture(const WorldMap& map, const Keyframe& keyframe, const Picture& picture,
                        const cv::Mat& free, const View& view, double radius_px, std::size_t most);

/// Where pixels of a keyframe, that show no point yet, are in another one. The pixel is not finite
/// where that is not known.
std::vector<Eigen::Vector2d> find_pixels(const WorldMap& map, const Keyframe& keyframe,
                                         std::span<const Eigen::Vector2d> px, const Keyframe& other,
                                         const Picture& other_picture);

/// From one picture to the next of a video: where the points have gone that were seen at the pixels
/// given; `guess` is the next camera's pose.
std::vector<Observation> follow(const WorldMap& map, const Picture& last,
                                std::span<const Observation> seen, const Picture& next,
                                const View& guess);

/// Pixel of a point, when it lies before the camera and within the picture.
std::optional<Eigen::Vector2d> pixel_of(const Eigen::Vector3d& p_world, const View& view);

/// Where the ray through a pixel meets the ground; empty when it does not, or at a grazing angle.
std::optional<Eigen::Vector3d> on_ground(const Eigen::Vector2d& px, const View& view,
                                         const Eigen::Hyperplane<double, 3>& ground);

}  // namespace handyar::world
