// SPDX-License-Identifier: MIT
#include "window.hpp"

#include <cstdlib>
#include <opencv2/highgui.hpp>

#include "handyar/io/error.hpp"

namespace handyar::cli {
namespace {

bool set(const char* variable) {
  const char* value = std::getenv(variable);
  return value != nullptr && *value != '\0';
}

}  // namespace

Window::Window(const std::string& title) : title_(title) {
  // The toolkits behind OpenCV do not fail without a display, they abort the program.
  if (!set("DISPLAY") && !set("WAYLAND_DISPLAY")) {
    throw io::Error("--show", "there is no display (neither DISPLAY nor WAYLAND_DISPLAY is set)");
  }
  try {
    cv::namedWindow(title_, cv::WINDOW_NORMAL | cv::WINDOW_KEEPRATIO | cv::WINDOW_GUI_NORMAL);
  } catch (const cv::Exception&) {
    throw io::Error("--show", "no window can be opened");
  }
}

Window::~Window() {
  try {
    cv::destroyWindow(title_);
  } catch (const cv::Exception&) {
  }
}

bool Window::show(const cv::Mat& bgr) {
  if (!shown_) cv::resizeWindow(title_, bgr.cols, bgr.rows);
  shown_ = true;
  cv::imshow(title_, bgr);
  const int key = cv::waitKey(1) & 0xff;
  if (key == 'q' || key == 27) return false;
  return cv::getWindowProperty(title_, cv::WND_PROP_VISIBLE) >= 1;
}

}  // namespace handyar::cli
