// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "handyar/attachment.hpp"
#include "handyar/render/presence.hpp"
#include "handyar/render/renderer.hpp"
#include "handyar/tracker.hpp"

namespace handyar::render {

/// One object standing on the tracked hand: for `track --model` and the demo.
///
///     HandOverlay overlay(find_model("bunny"));
///     overlay.draw(frame_bgr, camera, tracker, tracker.process(view, time_s));
class HandOverlay {
 public:
  /// `size_m`: longest side of the object; `where`: the place of the hand that it stands on. Throws
  /// io::Error without OpenGL 3.1.
  explicit HandOverlay(const Model& model, double size_m = 0.09,
                       Attachment where = Attachment::face,
                       std::shared_ptr<Context> context = headless_context());

  /// Draws the object into the frame that `result` was made from (8-bit BGR), seen by `camera`, by
  /// the tracker of either method. On a hand that closes it stays where the palm is held; where the
  /// pose is doubtful there is none.
  void draw(cv::Mat& frame_bgr, const Camera& camera, const auto& tracker,
            const TrackResult& result) {
    const HandModel hand = tracker.hand();
    std::optional<Eigen::Isometry3d> T_camera_hand;
    if (result.state == State::tracking && result.pose && !result.doubtful)
      T_camera_hand = result.pose->T_camera_hand;
    else if (result.held_pose)
      T_camera_hand = result.held_pose->T_camera_hand;
    draw(frame_bgr, camera, result.time_s, T_camera_hand, hand, tracker.mask(),
         T_hand_attachment(where_, hand, result));
  }

  /// The same from its parts. `T_camera_hand` empty, or its palm beside the mask: no hand, the
  /// object fades out.
  void draw(cv::Mat& frame_bgr, const Camera& camera, double time_s,
            const std::optional<Eigen::Isometry3d>& T_camera_hand, const HandModel& hand,
            const HandMask& mask, const Eigen::Isometry3d& T_hand_object);

 private:
  Renderer renderer_;
  Attachment where_;
  Instance instance_;
  Presence presence_;
  Eigen::Isometry3d T_hand_object_ = Eigen::Isometry3d::Identity();
};

}  // namespace handyar::render
