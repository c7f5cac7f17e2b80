// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "handyar/world/world_tracker.hpp"
#include "picture.hpp"

namespace handyar::world {

/// Tells when an open hand has lain still on its surroundings for half a second: when all that
/// while the surroundings have moved in the picture as the plane under the hand does. A camera may
/// move over a hand that lies still; a hand that moves over still surroundings, or is held high
/// before them while the camera moves, does not lie still.
class HandAtRest {
 public:
  enum class Rest : std::uint8_t { no, lying, lain };

  /// The next frame; `free`: see free_of_hand(). `lain` once it has lain long enough.
  Rest update(const Picture& picture, double time_s, const HandInWorld& hand, const cv::Mat& free,
              const Camera& camera);

  /// What the last attempt failed for, until the hand has lain still for a while again; that there
  /// was none, until there is one.
  std::optional<Hindrance> hindrance() const { return hindrance_; }
  /// The hand has lain, but that was not enough.
  void reject(Hindrance why) { hindrance_ = why; }

 private:
  struct Start {
    Picture picture;
    double time_s;
    Eigen::Isometry3d T_camera_hand;
    std::vector<cv::Point2f> corners_px;
  };
  std::optional<Hindrance> begin(const Picture& picture, double time_s, const HandInWorld& hand,
                                 const cv::Mat& free, const Camera& camera);
  std::optional<Hindrance> go_on(const Picture& picture, const HandInWorld& hand,
                                 const cv::Mat& free, const Camera& camera);

  std::optional<Start> start_;
  std::vector<cv::Point2f> now_px_;  // where the corners are
  std::optional<Hindrance> hindrance_ = Hindrance::no_hand;
};

}  // namespace handyar::world
