// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core.hpp>

#include "handyar/camera.hpp"
#include "handyar/world/world_tracker.hpp"

namespace handyar::world {

/// Where the hand does not hide the world, as a picture of the camera's size: 255, else 0. With a
/// pose the forearm is taken for hidden too. Empty without a hand: all is free.
cv::Mat free_of_hand(const HandInWorld& hand, const Camera& camera);

/// Whether a pixel lies in such a picture's free part.
inline bool is_free(const cv::Mat& free, const Eigen::Vector2d& px) {
  return free.empty() ||
         free.at<std::uint8_t>(static_cast<int>(px.y() + 0.5), static_cast<int>(px.x() + 0.5)) != 0;
}

}  // namespace handyar::world
