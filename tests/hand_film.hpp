// SPDX-License-Identifier: MIT
#pragma once

#include "drawn_hand.hpp"
#include "handyar/stages/hand_figure.hpp"
#include "handyar/tracker.hpp"

namespace handyar::test {

/// The mean figure, measured exactly.
inline HandModel drawn_hand_model() {
  FigureEstimate figure;
  figure.covariance *= 1e-4;
  HandModel hand = hand_of_figure(figure, Layout::thumb_right);
  hand.source = HandSource::truth;
  return hand;
}

/// Fingers closed to a fist, not quite as the tracker has them.
inline constexpr Posture kFist = {{-0.65, 0.03, 0, -0.02, -0.04}, {0.75, 1.25, 1.45, 1.4, 1.3}};

/// On the way from one posture to another.
inline Posture between(const Posture& a, const Posture& b, double share) {
  Posture p;
  for (int f = 0; f < kFingerCount; ++f) {
    p.abduction_rad[f] = (1 - share) * a.abduction_rad[f] + share * b.abduction_rad[f];
    p.flexion_rad[f] = (1 - share) * a.flexion_rad[f] + share * b.flexion_rad[f];
  }
  return p;
}

/// A hand before a camera, frame by frame, and the tracker that looks at it.
struct Film {
  explicit Film(const Config& config = {}, int width_px = 640, int height_px = 480)
      : camera(Camera::from_field_of_view(width_px, height_px)),
        hand_model(drawn_hand_model()),
        tracker(camera, hand_model, config) {}

  /// Fingers up, a little tilted, moving slowly.
  Eigen::Isometry3d pose_at(double t_s) const {
    return hand_at(0.42, tilt_rad * (1 + 0.43 * std::sin(2 * t_s)),
                   0.6 + 2 * (tilt_rad - deg(20)) * t_s, {0.015 * std::sin(1.5 * t_s), -0.03});
  }

  Picture picture() const {
    Picture p = textured && background ? *background : Picture(camera.width_px, camera.height_px);
    if (textured && !background) {
      p.texture(24, "Film");
      background = p;
    }
    if (present) p.paint(hand, camera, T_camera_hand);
    if (extra) extra(p);
    p.add_noise(noise, static_cast<std::uint32_t>(frame + 1));
    return p;
  }

  /// The next frame.
  const TrackResult& next() {
    time_s += 1 / fps;
    ++frame;
    T_camera_hand = pose_at(time_s);
    result = tracker.process(picture().view(), time_s);
    return result;
  }

  /// Seconds until `state`, or more than `limit_s` when it does not come.
  double until(State state, double limit_s) {
    const double start_s = time_s;
    while (time_s - start_s < limit_s + 0.5 / fps)
      if (next().state == state) return time_s - start_s;
    return limit_s + 1;
  }

  PosedFigure posed() const { return posed_figure(hand.appearance, hand.state); }

  Eigen::Vector2d true_tip_px(int finger) const {
    return camera.project(T_camera_hand * posed().tips_m.col(finger).eval());
  }

  Eigen::Vector2d true_root_px(int finger) const {
    return camera.project(T_camera_hand * posed().centres_m.col(sphere_of(finger, 0)).eval());
  }

  /// Largest distance of a tip reported to its true place; infinite when one is not reported.
  double worst_tip_px() const {
    double worst = 0;
    for (int f = 0; f < kFingerCount; ++f)
      worst = result.tips[f].known() ? std::max(worst, (result.tips[f].px - true_tip_px(f)).norm())
                                     : std::numeric_limits<double>::infinity();
    return worst;
  }

  double mean_tip_px() const {
    double sum = 0;
    for (int f = 0; f < kFingerCount; ++f)
      sum += (result.tips[f].px - true_tip_px(f)).norm() / kFingerCount;
    return sum;
  }

  Camera camera;
  HandModel hand_model;
  HandTracker tracker;
  DrawnHand hand;
  bool present = true, textured = false;
  std::function<void(Picture&)> extra;
  mutable std::optional<Picture> background;
  double tilt_rad = deg(20);
  double noise = 3, fps = 30, time_s = 0;
  int frame = 0;
  Eigen::Isometry3d T_camera_hand = Eigen::Isometry3d::Identity();
  TrackResult result;
};

}  // namespace handyar::test
