// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "handyar/render/context.hpp"

struct GLFWwindow;

namespace handyar::render {

/// The size of a window for a picture on a screen of which so much is free: the picture's, or
/// smaller with the same aspect.
cv::Size window_size(cv::Size picture_px, cv::Size free_px);

/// A window on the screen that shows pictures; its context can draw overlays as well. One at a
/// time.
class Window final : public Context {
 public:
  /// As large as the picture, or as the screen allows. Throws io::Error when there is no screen.
  Window(int width_px, int height_px, const std::string& title);
  ~Window() override;

  void make_current() override;

  /// Shows an 8-bit BGR picture for at least about `wait_s`, scaled to the window with its aspect
  /// kept. False once the person has closed the window or pressed Escape or Q.
  bool show(const cv::Mat& picture_bgr, double wait_s = 0);

  /// What was typed since the last call.
  std::string take_typed();

 private:
  struct Painter;
  GLFWwindow* window_ = nullptr;
  std::string typed_;
  std::unique_ptr<Painter> painter_;
};

}  // namespace handyar::render
