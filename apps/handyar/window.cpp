// SPDX-License-Identifier: MIT
#include "window.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>
#include <opencv2/highgui.hpp>

#include "handyar/io/error.hpp"

namespace handyar::cli {
namespace {

bool set(const char* variable) {
  const char* value = std::getenv(variable);
  return value != nullptr && *value != '\0';
}

// Whether the X server named by DISPLAY answers. Asked through the library that the toolkits load
// themselves, so that nothing more has to be installed; without it, it is left to them.
bool x_server_answers() {
  void* const xcb = ::dlopen("libxcb.so.1", RTLD_LAZY);
  if (xcb == nullptr) return true;
  const auto connect = reinterpret_cast<void* (*)(const char*, int*)>(::dlsym(xcb, "xcb_connect"));
  const auto has_error = reinterpret_cast<int (*)(void*)>(::dlsym(xcb, "xcb_connection_has_error"));
  const auto disconnect = reinterpret_cast<void (*)(void*)>(::dlsym(xcb, "xcb_disconnect"));
  if (connect == nullptr || has_error == nullptr || disconnect == nullptr) return true;
  void* const connection = connect(nullptr, nullptr);
  const bool answers = has_error(connection) == 0;
  disconnect(connection);
  return answers;
}

}  // namespace

Window::Window(const std::string& title) : title_(title) {
  // The toolkits behind OpenCV do not fail without a display, they abort the program.
  if (!set("DISPLAY") && !set("WAYLAND_DISPLAY")) {
    throw io::Error("--show", "there is no display (neither DISPLAY nor WAYLAND_DISPLAY is set)");
  }
  if (set("DISPLAY") && !set("WAYLAND_DISPLAY") && !x_server_answers()) {
    throw io::Error("--show",
                    std::string("the display ") + std::getenv("DISPLAY") + " does not answer");
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

bool Window::show(const cv::Mat& bgr, double wait_s) {
  if (!shown_) cv::resizeWindow(title_, bgr.cols, bgr.rows);
  shown_ = true;
  cv::imshow(title_, bgr);
  const int key = cv::waitKey(std::clamp(static_cast<int>(1000 * wait_s), 1, 1000)) & 0xff;
  if (key == 'q' || key == 27) return false;
  return cv::getWindowProperty(title_, cv::WND_PROP_VISIBLE) >= 1;
}

}  // namespace handyar::cli
