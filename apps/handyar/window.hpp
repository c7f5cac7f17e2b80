// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>

namespace handyar::cli {

/// A window on the desktop. Throws io::Error without a display.
class Window {
 public:
  explicit Window(const std::string& title);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  /// Shows the picture for at least about `wait_s`. False when the user wants to end: q, Esc, or the
  /// window was closed.
  bool show(const cv::Mat& bgr, double wait_s);

 private:
  std::string title_;
  bool shown_ = false;
};

}  // namespace handyar::cli
