// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>

#include "handyar/render/window.hpp"

namespace handyar::cli {

/// A window with keys: `?` shows them.
class Viewer {
 public:
  Viewer(int width_px, int height_px, bool annotated, bool mirrored)
      : annotated_(annotated), mirrored_(mirrored), window_(width_px, height_px, "handyar") {}

  /// Shows a picture for at least `wait_s`, and on while it is paused; false when the person has
  /// ended it.
  bool show(const cv::Mat& bgr, double wait_s);

  bool annotated() const { return annotated_; }
  bool mirrored() const { return mirrored_; }
  double paused_s() const { return paused_s_; }  ///< altogether
  /// Whether another object was asked for since the last call.
  bool take_next_object();
  /// Whether the hand is to be learned anew, asked since the last call.
  bool take_new_hand();

 private:
  void obey(char key, const cv::Mat& bgr);

  bool annotated_, mirrored_;
  bool help_ = false, paused_ = false, next_object_ = false, new_hand_ = false;
  double paused_s_ = 0;
  cv::Mat picture_;
  render::Window window_;
};

}  // namespace handyar::cli
