// SPDX-License-Identifier: MIT
#include "handyar/calibration/session.hpp"

#include <opencv2/imgproc.hpp>

#include "handyar/stages/evidence.hpp"
#include "text.hpp"

namespace handyar {
namespace {

// Without the board in view, only every twelfth frame is worth a thorough search.
constexpr int kThoroughEvery = 12;

}  // namespace

CalibrationView hand_view(const TrackResult& result, const HandModel& learned) {
  CalibrationView v;
  if (result.state != State::tracking || result.doubtful) return v;
  v.tips = result.tips;
  v.webs = result.webs;
  if (result.raw_pose) v.T_camera_hand = result.raw_pose->T_camera_hand;
  v.hand = learned;
  v.posture = posture_of(result);
  return v;
}

CalibrationSession::CalibrationSession(const Board& board, cv::Size image_size, bool hand_wanted)
    : board_(board), image_size_(image_size), coverage_(board, image_size, hand_wanted) {}

std::vector<cv::Point2f> CalibrationSession::find(const cv::Mat& grey) {
  auto corners = find_board(grey, board_, BoardSearch::quick);
  if (corners.empty() && misses_ % kThoroughEvery == 0)
    corners = find_board(grey, board_, BoardSearch::thorough);
  misses_ = corners.empty() ? misses_ + 1 : 0;
  if (misses_ % kThoroughEvery == kThoroughEvery / 2 && !other_board_)
    other_board_ = find_any_board(grey);
  return corners;
}

const CalibrationView& CalibrationSession::add(const cv::Mat& bgr, const TrackResult& result,
                                               const HandModel& learned) {
  if (bgr.size() != image_size_)
    throw CalibrationError(text("a picture has %dx%d pixels, those of this calibration have %dx%d",
                                bgr.cols, bgr.rows, image_size_.width, image_size_.height));
  cv::Mat grey;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  CalibrationView v = hand_view(result, learned);
  v.corners_px = find(grey);
  if (v.board_seen()) v.blur_px = edge_width_px(grey, board_, v.corners_px);
  coverage_.add(v);
  views_.push_back(std::move(v));
  return views_.back();
}

CameraCalibration CalibrationSession::camera() const {
  try {
    return calibrate_camera(views_, board_, image_size_);
  } catch (const CalibrationError& e) {
    const bool never =
        std::none_of(views_.begin(), views_.end(), [](const auto& v) { return v.board_seen(); });
    if (!never || !other_board_) throw;
    throw CalibrationError(
        text("there is no board of %dx%d inner corners, but one of %dx%d: count "
             "the corners where four squares meet, not the squares",
             board_.columns, board_.rows, other_board_->width, other_board_->height));
  }
}

}  // namespace handyar
