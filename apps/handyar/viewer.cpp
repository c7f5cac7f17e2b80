// SPDX-License-Identifier: MIT
#include "viewer.hpp"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <utility>

#include "command.hpp"
#include "handyar/io/error.hpp"
#include "handyar/io/picture_file.hpp"
#include "handyar/opencv/annotate.hpp"

namespace handyar::cli {
namespace {

constexpr double kPausedPicture_s = 0.05;

const std::vector<std::string> kHelp = {"space  pause", "a  annotation", "o  next object",
                                        "m  mirror",    "s  screenshot", "r  learn hand anew",
                                        "?  this help", "q  end"};

// The first of handyar-1.png, handyar-2.png, ... that is not there.
std::string screenshot_name() {
  for (int number = 1;; ++number) {
    const std::string name = "handyar-" + std::to_string(number) + ".png";
    if (!std::filesystem::exists(name)) return name;
  }
}

}  // namespace

void Viewer::obey(char key, const cv::Mat& bgr) {
  switch (key) {
    case ' ':
      paused_ = !paused_;
      return;
    case 'a':
      annotated_ = !annotated_;
      return;
    case 'm':
      mirrored_ = !mirrored_;
      return;
    case 'o':
      next_object_ = true;
      return;
    case 'r':
      new_hand_ = true;
      return;
    case '?':
    case 'h':
      help_ = !help_;
      return;
    case 's': {
      const std::string name = screenshot_name();
      try {
        io::write_picture(name, bgr);
        std::cerr << "handyar: " << name << " written\n";
      } catch (const io::Error& e) {  // no reason to end
        std::cerr << "handyar: " << e.what() << '\n';
      }
      return;
    }
    default:
      return;
  }
}

bool Viewer::show(const cv::Mat& bgr, double wait_s) {
  const double start_s = steady_now_s();
  do {
    const cv::Mat* shown = &bgr;
    if (help_ || paused_) {
      bgr.copyTo(picture_);
      if (help_) draw_lines(picture_, kHelp);
      if (paused_ && !help_) draw_lines(picture_, {"paused"});
      shown = &picture_;
    }
    if (!window_.show(*shown, paused_ ? kPausedPicture_s : wait_s)) return false;
    for (const char key : window_.take_typed()) obey(key, bgr);
  } while (paused_ && interrupt() == 0);
  if (const double took_s = steady_now_s() - start_s;
      took_s > std::max(0.0, wait_s) + 2 * kPausedPicture_s)
    paused_s_ += took_s;
  return true;
}

bool Viewer::take_new_hand() { return std::exchange(new_hand_, false); }

bool Viewer::take_next_object() { return std::exchange(next_object_, false); }

}  // namespace handyar::cli
