// SPDX-License-Identifier: MIT
#include "handyar/render/hand_overlay.hpp"

#include "hand_distance.hpp"
#include "handyar/opencv/lens.hpp"

namespace handyar::render {

namespace {

/// A pose whose palm lies beside the hand in the picture is wrong: nothing stands on it.
bool on_hand(const Eigen::Vector3d& p_camera, const HandMask& mask, const Camera& camera) {
  constexpr double kBeside = 0.02;  // of the picture's width: masks have holes
  if (mask.width == 0) return true;
  const auto px = shown_at(camera, p_camera);
  return px && distance_px(mask, *px) <= kBeside * camera.width_px;
}

}  // namespace

HandOverlay::HandOverlay(const Model& model, double size_m, Attachment where,
                         std::shared_ptr<Context> context)
    : renderer_(std::move(context)), where_(where) {
  instance_.model = renderer_.add(model);
  instance_.size_m = size_m;
}

void HandOverlay::draw(cv::Mat& frame_bgr, const Camera& camera, double time_s,
                       const std::optional<Eigen::Isometry3d>& T_camera_hand, const HandModel& hand,
                       const HandMask& mask, const Eigen::Isometry3d& T_hand_object) {
  const Camera seen_by = camera.scaled_to(frame_bgr.cols, frame_bgr.rows);
  const bool here = T_camera_hand && on_hand(*T_camera_hand * hand.palm_centre_m(), mask, seen_by);
  presence_.update(time_s, here ? T_camera_hand : std::nullopt,
                   here ? std::optional(hand.layout) : std::nullopt);
  const Presence::Sighting seen = presence_.sighting();
  // After a flip it leaves from the face on which it stood.
  if (here && seen.layout == hand.layout) T_hand_object_ = T_hand_object;
  // What stands on a fingertip or behind the hand throws no shadow that could be seen on it.
  const bool on_visible_face = T_hand_object_.linear()(2, 2) > 0.9;
  instance_.ground = on_visible_face ? Ground::hand : Ground::none;
  instance_.time_s = time_s;
  instance_.opacity = seen.opacity;
  instance_.T_camera_object = seen.T_camera_hand * T_hand_object_;
  HandOccluder occluder{mask, seen.T_camera_hand, 0.008};
  renderer_.draw(frame_bgr, camera, {&instance_, 1}, occluder);
}

}  // namespace handyar::render
