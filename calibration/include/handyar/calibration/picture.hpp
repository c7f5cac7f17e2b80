// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>

#include "handyar/calibration/hand_calibration.hpp"

namespace handyar {

/// A calibrated hand seen from straight above, to scale (paper Figure 5): fingertips with their
/// error ellipses (two standard deviations), its figure, and the axes of the hand frame.
struct HandPicture {
  HandModel hand;
  std::optional<Board> board;  ///< drawn too, with T_board_hand
  Eigen::Isometry3d T_board_hand = Eigen::Isometry3d::Identity();
  std::optional<Eigen::Matrix<double, 3, kFingerCount>>
      plane_tips_board_m;  ///< tips measured the paper's way, in the board frame: crosses
};
cv::Mat draw_hand(const HandPicture& picture);

}  // namespace handyar
