// SPDX-License-Identifier: MIT
#include "diagnosis.hpp"

#include <algorithm>
#include <cmath>

namespace handyar::cli {
namespace {

constexpr int kSamples = 2000;     // a frame; some will do
constexpr double kDarkLuma = 45;   // mean of a picture
constexpr double kMuchSkin = 0.6;  // share of a picture, more than an open hand takes

constexpr double kSomeSkin = 0.03;  // about an open hand at the farthest
constexpr double kGreyChroma = 4;  // mean distance of a pixel's channels; a camera's noise has less

struct Look {
  double skin = 0, luma = 0, chroma = 0;
};

// Skin of every tone is redder than it is yellow, and yellower than it is blue.
bool like_skin(int r, int g, int b) {
  return r > 60 && r > g && g >= b - 5 && r - b > 15 && r - g > 5;
}

Look look_at(const cv::Mat& bgr) {
  const int step = std::max(1, int(std::sqrt(double(bgr.total()) / kSamples)));
  Look look;
  int count = 0;
  for (int y = step / 2; y < bgr.rows; y += step)
    for (int x = step / 2; x < bgr.cols; x += step, ++count) {
      const cv::Vec3b& p = bgr.at<cv::Vec3b>(y, x);
      look.skin += like_skin(p[2], p[1], p[0]);
      look.chroma += std::max({p[0], p[1], p[2]}) - std::min({p[0], p[1], p[2]});
      look.luma += 0.299 * p[2] + 0.587 * p[1] + 0.114 * p[0];
    }
  look.skin /= count;
  look.luma /= count;
  look.chroma /= count;
  return look;
}

}  // namespace

void Diagnosis::look(const cv::Mat& bgr, const TrackResult& result) {
  ++frames_;
  tracked_ += result.state == State::tracking;
  acquiring_ += result.state == State::acquiring;
  if (result.state == State::tracking) return;
  const Look look = look_at(bgr);
  dark_ += look.luma < kDarkLuma;
  grey_ += look.chroma < kGreyChroma;
  filled_ += look.skin >= kMuchSkin;
  skin_ += look.skin >= kSomeSkin;
}

std::string Diagnosis::missing(const std::string& hand_file) const {
  if (frames_ == 0 || tracked_ > 0) return "";
  const auto mostly = [this](std::int64_t count) { return 2 * count > frames_; };
  const bool seen = 20 * acquiring_ >= frames_;
  if (mostly(dark_) && !seen) return "the pictures are too dark";
  if (mostly(grey_)) return "the pictures are grey: a hand shows in colour";
  if (seen && !hand_file.empty())
    return "a hand was seen that does not fit " + hand_file + "; without --hand any hand will do";
  if (seen) return "a hand was seen, but not for long: spread the fingers and hold it still";
  if (mostly(filled_))
    return "nearly all is of skin's colour: the hand is too near, or the room is coloured like it";
  if (mostly(skin_)) return "skin was seen, but not five fingers: spread them";
  return "nothing of skin's colour was seen: show an open hand";
}

}  // namespace handyar::cli
