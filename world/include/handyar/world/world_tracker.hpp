// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string_view>

#include "handyar/camera.hpp"
#include "handyar/pose.hpp"
#include "handyar/tracker.hpp"
#include "handyar/world/world_map.hpp"

namespace handyar::world {

enum class WorldState : std::uint8_t {
  none,     ///< no frame was set
  setting,  ///< the hand lies still, the frame will be set where it is
  tracked,
  lost  ///< there is a frame, but what is seen is not known to lie in it
};
[[nodiscard]] std::string_view name(WorldState state) noexcept;

/// Why the hand has not set the frame.
enum class Hindrance : std::uint8_t {
  no_hand,
  unsure,     ///< a hand is seen, but its pose is not to be relied on
  tilted,     ///< looked at from the side: what it lies on would not be seen
  bare,       ///< too few corners around it
  moving,     ///< against its surroundings
  off_ground  ///< they are still, but lie deeper than the plane under the hand
};
/// The word for files: as the enumerator is written.
[[nodiscard]] std::string_view name(Hindrance hindrance) noexcept;

/// The hand in a frame, as the world needs it.
struct HandInWorld {
  HandMask mask;  ///< where it hides the world; width 0: nowhere
  /// While the pose is to be relied on.
  std::optional<Eigen::Isometry3d> T_camera_hand;
  double thickness_m = 0.005;  ///< height of the hand frame above what the hand lies on
  bool scale_assumed = false;

  /// From a tracker of either method and its result.
  static HandInWorld of(const auto& tracker, const TrackResult& result) {
    HandInWorld hand{tracker.mask(), std::nullopt, tracker.hand().thickness_m,
                     result.scale_assumed};
    if (result.state == State::tracking && result.pose && !result.doubtful)
      hand.T_camera_hand = result.pose->T_camera_hand;
    return hand;
  }
};

/// The world as one frame shows it.
struct WorldResult {
  WorldState state = WorldState::none;
  std::optional<Hindrance> hindrance;  ///< while there is no frame, unless all goes well
  std::optional<Eigen::Isometry3d> T_camera_world;  ///< while tracked
  int points = 0;   ///< of the map, that should have been seen in this frame
  int inliers = 0;  ///< of them, seen where the pose says
  double rms_px = 0;
  double sigma_rotation_rad = 0, sigma_translation_m = 0;
  bool scale_assumed = false;
};

/// Where mapping runs: keyframes, new points and the bundle adjustment.
enum class Mapping : std::uint8_t {
  at_once,    ///< within process(): the same frames give the same results
  background  ///< on a thread beside it, for live cameras
};

/// A world frame that is set by the hand and kept by natural features.
///
///     HandTracker hands(camera, average_adult_hand());
///     WorldTracker worlds(camera);
///     const TrackResult hand = hands.process(view, time_s);
///     const WorldResult world = worlds.process(bgr, time_s, HandInWorld::of(hands, hand));
///
/// An open hand that has lain still on its surroundings for half a second sets the frame; from then
/// on the surroundings hold it, with or without a hand. One thread at a time.
class WorldTracker {
 public:
  explicit WorldTracker(const Camera& camera, Mapping mapping = Mapping::at_once);
  /// Begins lost, in a map that was made before, perhaps by another camera.
  WorldTracker(const Camera& camera, WorldMap map, Mapping mapping = Mapping::at_once);
  ~WorldTracker();
  WorldTracker(WorldTracker&&) noexcept;
  WorldTracker& operator=(WorldTracker&&) noexcept;

  /// Takes the next frame; times must increase. One that is not 8-bit BGR of the camera's size is
  /// refused by cv::Exception and changes nothing.
  WorldResult process(const cv::Mat& bgr, double time_s, const HandInWorld& hand);

  /// The surroundings as far as they are known; null before a frame was set.
  [[nodiscard]] std::shared_ptr<const WorldMap> map() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace handyar::world
