// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "handyar/calibration/error.hpp"
#include "handyar/calibration/hand_frame.hpp"
#include "handyar/calibration/still_points.hpp"
#include "handyar/calibration/view.hpp"

namespace handyar {

/// A hand measured while it lay still beside the board, face up, in two ways.
struct HandCalibration {
  HandModel by_triangulation;  ///< with standard deviations and the figure they tell
  HandModel by_plane;          ///< the paper's way: at thickness_m above the board
  Eigen::Isometry3d T_board_hand = Eigen::Isometry3d::Identity();  ///< of by_triangulation
  StillPoints tips;             ///< triangulated, in the board frame
  StillPoints plane_tips;       ///< the paper's way, in the board frame
  double height_m = 0;          ///< mean height of the tips above the board as triangulated
  double rms_difference_m = 0;  ///< between the two, in the plane of the board
  std::vector<int> views_used;  ///< indices into the views given
};

/// Measures the hand in the views that show it together with the board (paper 2.4). Throws
/// CalibrationError when there are too few, when the hand moved, or when its size shows that the
/// board's squares are not what was said.
HandCalibration calibrate_hand(std::span<const CalibrationView> views, const Camera& camera,
                               const Board& board, double thickness_m = 0.005);

}  // namespace handyar
