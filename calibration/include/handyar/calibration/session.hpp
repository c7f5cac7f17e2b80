// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "handyar/calibration/camera_calibration.hpp"
#include "handyar/calibration/guidance.hpp"
#include "handyar/calibration/hand_calibration.hpp"

namespace handyar {

/// A calibration recording in the making: frames go in one after the other; what was seen in them
/// comes out, at last camera and hand.
class CalibrationSession {
 public:
  CalibrationSession(const Board& board, cv::Size image_size, bool hand_wanted = true);

  /// Looks for the board in the frame and takes the tracker's view of the hand with it. Throws
  /// CalibrationError where the frame is not of the session's size.
  const CalibrationView& add(const cv::Mat& bgr, const TrackResult& result,
                             const HandModel& learned);

  const Board& board() const { return board_; }
  const std::vector<CalibrationView>& views() const { return views_; }
  const Coverage& coverage() const { return coverage_; }

  /// See calibrate_camera. When the board was never found but another one was seen, the message of
  /// the CalibrationError says which.
  CameraCalibration camera() const;

 private:
  std::vector<cv::Point2f> find(const cv::Mat& grey);

  Board board_;
  cv::Size image_size_;
  std::vector<CalibrationView> views_;
  Coverage coverage_;
  int misses_ = 0;                       // frames since the board was last seen
  std::optional<cv::Size> other_board_;  // of other counts, seen while the wanted one was not
};

/// The hand in a frame as the tracker saw it and as it had learned it; no board.
CalibrationView hand_view(const TrackResult& result, const HandModel& learned);

}  // namespace handyar
