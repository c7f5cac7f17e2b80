// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "handyar/calibration/board.hpp"
#include "handyar/stages/hand_figure.hpp"
#include "handyar/tracker.hpp"

namespace handyar {

/// What one frame of a calibration recording shows.
struct CalibrationView {
  std::vector<cv::Point2f> corners_px;  ///< of the board, row by row; empty: not seen
  double blur_px = 0;                   ///< width of the board's edges, see edge_width_px
  std::array<Tip, kFingerCount> tips;
  std::array<Tip, kValleyCount> webs;
  std::optional<Eigen::Isometry3d> T_camera_hand;  ///< while tracked
  HandModel hand;                                  ///< as learned until then, where tracked
  Posture posture;                                 ///< in which it was held

  bool board_seen() const { return !corners_px.empty(); }
  bool hand_seen() const {
    return std::all_of(tips.begin(), tips.end(), [](const Tip& t) { return t.seen; });
  }
};

/// How a board or a hand was looked at; what makes two views different.
struct Viewpoint {
  Eigen::Vector2d centre;  ///< of the object in the picture, (0, 0) to (1, 1)
  Eigen::Vector3d normal;  ///< of the object, towards the camera, in camera axes
  double distance_m = 0;
};
Viewpoint viewpoint(const Eigen::Isometry3d& T_camera_object, const Eigen::Vector3d& centre_m,
                    const Eigen::Vector3d& normal_object, const Camera& camera);

/// How far two viewpoints lie apart: a third of the picture, 20 degrees of direction or 35 % of
/// distance count 1.
double difference(const Viewpoint& a, const Viewpoint& b);

/// The largest angle between the directions from which an object was seen (radians).
double directions_span_rad(std::span<const Viewpoint> viewpoints);

/// Indices of at most `count` viewpoints that lie as far apart as possible in place, direction and
/// distance (farthest-point choice), in increasing order; views that repeat chosen ones are left.
std::vector<int> choose_diverse(std::span<const Viewpoint> viewpoints, int count);

}  // namespace handyar
