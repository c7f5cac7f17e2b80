// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "handyar/camera.hpp"
#include "handyar/evaluation/markers.hpp"
#include "handyar/hand_model.hpp"
#include "handyar/pose.hpp"

namespace handyar::evaluation {

using TipsPx = std::array<Eigen::Vector2d, kFingerCount>;  ///< in finger order

/// How a finger truly stands against the neutral posture; signs as in FingerState.
struct TrueFinger {
  double abduction_deg = 0;
  double flexion_deg = 0;  ///< at the knuckle
};

/// What is exactly known of one frame of a rendered sequence. With a rolling shutter the pose is
/// that of the middle row, and each fingertip is where its own row saw it.
struct TruthFrame {
  Eigen::Isometry3d T_camera_world = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_camera_hand = Eigen::Isometry3d::Identity();  ///< +z towards the camera
  bool other_face = false;  ///< the frame above was turned: the face that the model mirrors shows
  Layout layout = Layout::thumb_right;  ///< as seen in the picture
  TipsPx tips_px;
  bool all_tips_visible = false;  ///< all five, none hidden or outside, the fingers outstretched
  /// Less than a twentieth of the hand is in the picture, or its fingers are folded, to a fist or a
  /// four: nothing to be tracked.
  bool no_open_hand = false;
  std::optional<TipsPx> other_tips_px;                          ///< of a second hand
  std::optional<std::array<TrueFinger, kFingerCount>> fingers;  ///< where they live

  double span_px() const { return (tips_px[0] - tips_px[4]).norm(); }
  double distance_m() const { return T_camera_hand.translation().norm(); }
  /// Angle (rad) between the hand's normal and the line of sight: 0 when seen face on.
  double tilt_rad() const;
};

/// A rendered sequence's truth.json, in metres.
struct Truth {
  Camera camera;
  HandModel hand;  ///< layout thumb_right, source truth
  double frames_per_second = 30;
  bool hand_still_in_world =
      false;  ///< only the camera moves, so hand and board are one rigid body
  std::optional<Board> board;
  std::optional<Eigen::Isometry3d> T_world_board;
  std::vector<Marker> markers;
  std::vector<Eigen::Isometry3d> T_world_marker;  ///< one for each marker
  std::vector<TruthFrame> frames;                 ///< index: frame number
};

/// Throws io::Error.
Truth read_truth(const std::filesystem::path& file);

}  // namespace handyar::evaluation
