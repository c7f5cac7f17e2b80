// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <opencv2/core/mat.hpp>
#include <string>
#include <string_view>

#include "handyar/calibration/view.hpp"

namespace handyar {

/// From where the board was looked at, as the person with the camera says it.
enum class BoardSide : std::uint8_t { above, left, right, near, far };
inline constexpr int kSideCount = 5;
inline constexpr std::array<std::string_view, kSideCount> kSideNames = {
    "above", "the left", "the right", "the near side", "the far side"};

/// Which views a calibration recording already has; grows with each frame.
class Coverage {
 public:
  static constexpr int kColumns = 8, kRows = 6;
  static constexpr int kViewsWanted = 20;      ///< different ones
  static constexpr int kSidesWanted = 4;       ///< of five
  static constexpr double kCellsWanted = 0.4;  ///< of the picture

  Coverage(const Board& board, cv::Size image_size, bool hand_wanted = true);

  /// Counts a frame when it is sharp, shows the board and differs from those before.
  void add(const CalibrationView& view);

  int views() const { return static_cast<int>(viewpoints_.size()); }
  int hand_views() const { return hand_views_; }  ///< of these, with the hand
  int views_from(BoardSide side) const { return sides_[static_cast<int>(side)]; }
  bool cell(int column, int row) const { return cells_[row * kColumns + column]; }
  double cells_share() const;
  int sides_seen() const;
  /// The hand is to be measured too and is in too few views.
  bool needs_hand() const { return hand_wanted_ && hand_views_ < kViewsWanted / 2; }
  /// Views, hand, sides and cells are enough: further frames add little.
  bool done() const;

 private:
  Board board_;
  Camera rough_;
  double max_blur_px_;
  bool hand_wanted_;
  std::vector<Viewpoint> viewpoints_;
  std::array<int, kSideCount> sides_{};
  std::array<bool, kColumns * kRows> cells_{};
  int hand_views_ = 0;
};

/// The one thing to do next, for the person with the camera. `now` is the newest frame.
std::string advice(const Coverage& coverage, const CalibrationView& now);

/// The frame with the board's corners and the fingertips that were found, beside it the coverage:
/// the picture's cells, the sides, the count of views, and the advice below.
cv::Mat draw_guidance(const cv::Mat& bgr, const Coverage& coverage, const CalibrationView& now);

}  // namespace handyar
