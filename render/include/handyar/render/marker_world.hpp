// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "handyar/camera.hpp"
#include "handyar/render/scene.hpp"

namespace handyar::render {

/// Where a scene's markers stand before the camera, frame by frame.
///
/// All markers make one world. Their places in it are the scene's, or are learned from frames that
/// show several of them; so a marker under the hand keeps its place as long as another is seen.
/// Both kinds of print, ArUco and AprilTag, are found by OpenCV's detector, which has the
/// dictionaries of both and gives their corners in one order and refined in one way.
class MarkerWorld {
 public:
  /// The dictionaries must be known (dictionary_number). Throws io::Error where the program was
  /// built without what finds markers.
  explicit MarkerWorld(std::vector<SceneMarker> markers);
  ~MarkerWorld();
  MarkerWorld(MarkerWorld&&) noexcept;
  MarkerWorld& operator=(MarkerWorld&&) noexcept;

  /// Looks for the markers in the next frame (8-bit BGR), seen by a camera of its size.
  void observe(const cv::Mat& frame_bgr, const Camera& camera, double time_s);

  /// Pose of a marker (index in the list given), or of the world with -1. Without any marker in
  /// view it stays where it was for a short while; then, and before it was ever seen, empty.
  std::optional<Eigen::Isometry3d> T_camera_marker(int index) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace handyar::render
