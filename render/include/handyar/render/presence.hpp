// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "handyar/hand_model.hpp"

namespace handyar::render {

/// Lets an object come and go without a jump: it fades in where the hand is, fades out quickly
/// where the hand was last, for nothing is to hang in the air that the hand has left, and after a
/// flip leaves one face before it comes back on the other.
class Presence {
 public:
  explicit Presence(double appear_s = 0.3, double vanish_s = 0.12)
      : appear_s_(appear_s), vanish_s_(vanish_s) {}

  struct Sighting {
    Eigen::Isometry3d T_camera_hand = Eigen::Isometry3d::Identity();
    Layout layout = Layout::thumb_right;
    float opacity = 0;  ///< eased, 0 .. 1
  };

  /// The hand at `time_s`, if there is one; the layout is the visible face's.
  void update(double time_s, const std::optional<Eigen::Isometry3d>& T_camera_hand,
              std::optional<Layout> layout);

  /// What to draw now: opacity 0 means nothing.
  Sighting sighting() const;

 private:
  double appear_s_, vanish_s_;
  double last_s_ = 0;
  double shown_ = 0;  // linear in time, 0 .. 1
  bool started_ = false;
  Sighting where_;
};

}  // namespace handyar::render
