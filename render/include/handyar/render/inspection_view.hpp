// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "handyar/render/inspection.hpp"
#include "handyar/render/marker_world.hpp"
#include "handyar/render/renderer.hpp"
#include "handyar/render/scene.hpp"
#include "handyar/tracker.hpp"

namespace handyar::render {

/// What select-and-inspect needs to know of the hand in a frame.
struct HandInView {
  HandMask mask;
  bool fingertips_seen = false;  ///< at least as candidates: the region is a hand, not a wall
  std::optional<Eigen::Isometry3d> T_camera_hand;  ///< while the fingertips are tracked
  HandModel model;                                 ///< in the layout in view
  TrackResult result;

  static HandInView of(const auto& tracker, const TrackResult& result) {
    HandInView hand{tracker.mask(), false, std::nullopt, tracker.hand(), result};
    hand.fingertips_seen = result.state == State::acquiring || result.state == State::tracking;
    if (result.state == State::tracking && result.pose)
      hand.T_camera_hand = result.pose->T_camera_hand;
    return hand;
  }
};

/// Select-and-inspect before the camera (paper 3.3): finds the scene's markers, draws its objects
/// where they stand or on the hand, and lets the hand fetch them.
class InspectionView {
 public:
  /// Loads the scene's models; throws io::Error.
  InspectionView(const Scene& scene, const InspectionConfig& config = {},
                 std::shared_ptr<Context> context = headless_context());

  /// Takes the next frame (8-bit BGR), seen by a camera of its size; says what happened in it.
  std::optional<InspectionEvent> update(const cv::Mat& frame_bgr, const Camera& camera,
                                        double time_s, const HandInView& hand);

  /// Draws the objects as they are since the last update into that frame.
  void draw(cv::Mat& frame_bgr, const Camera& camera, const HandInView& hand);

  /// The object that the last event was about.
  const SceneObject& object() const {
    return scene_.objects[static_cast<std::size_t>(last_object_)];
  }

  /// Whether the marker of any object has been seen so far.
  bool any_seen() const;

 private:
  struct Placed {
    Eigen::AlignedBox3f box;                           // of the model, longest side 1
    std::optional<Eigen::Isometry3d> T_camera_object;  // in its place; kept once seen
    bool seen = false;                                 // its place is known in this frame
    double shown = 0;                                  // fades in and out, 0 .. 1
  };

  void place(double step_s);
  void follow_hand(const HandInView& hand, double step_s);
  double distance_to_px(std::size_t object, const Camera& camera, const HandInView& hand) const;
  void arrange(double time_s);

  Scene scene_;
  MarkerWorld world_;
  Inspection inspection_;
  Renderer renderer_;
  std::vector<Placed> placed_;
  std::vector<Instance> instances_;
  std::vector<double> distances_px_;
  Eigen::Isometry3d T_camera_hand_ = Eigen::Isometry3d::Identity();   // last known
  Eigen::Isometry3d T_camera_stand_ = Eigen::Isometry3d::Identity();  // of an object on the hand
  double following_ = 0;  // 0 .. 1: how far the stand has caught up with the hand after a loss
  double last_s_ = 0;
  double glow_ = 0;
  int last_object_ = 0;
};

}  // namespace handyar::render
