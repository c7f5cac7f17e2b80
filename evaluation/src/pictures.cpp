// SPDX-License-Identifier: MIT
#include "handyar/evaluation/pictures.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <opencv2/imgproc.hpp>

#include "handyar/io/error.hpp"
#include "handyar/io/frame_source.hpp"
#include "handyar/io/picture_file.hpp"
#include "handyar/opencv/annotate.hpp"

namespace handyar::evaluation {
namespace {

constexpr int kSamples = 4, kWorst = 4;
constexpr int kApartFrames = 10;  ///< neighbours show the same
constexpr int kWidth_px = 480;
constexpr int kJpegQuality = 82;
constexpr int kSubPixelBits = 4;

double largest_px(const FrameError& e) {
  double most = 0;
  for (const double px : e.tips.px)
    if (std::isfinite(px)) most = std::max(most, px);
  return most;
}

/// 0 .. 1: of fingertips and pose the worse; a fingertip's 100 pixels count like 60 degrees and
/// like two fifths of the distance.
double size_of(const FrameError& e) {
  double most = largest_px(e) / 100;
  for (const double part : {e.filtered.rotation_deg / 60, e.filtered.translation_percent / 40})
    if (std::isfinite(part)) most = std::max(most, part);
  return std::tanh(most);
}

/// How bad a frame is: the whole number says what kind of fault, the rest how large.
double badness(const Analysis& a, std::size_t i) {
  const TrackResult& r = a.recording.main_track().results[i];
  if (!a.has_truth()) {
    if (r.state == State::lost) return 2;
    return r.raw_pose && std::isfinite(r.raw_pose->rms_px) ? std::tanh(r.raw_pose->rms_px / 10) : 0;
  }
  const FrameError& e = a.main_track().errors[i];
  const double size = size_of(e);
  if (e.no_open_hand && e.tracked) return 4;
  if (e.eligible && e.wrong) return 3 + size;
  if (e.eligible && !e.tracked) return 2;
  return e.counted() ? size : 0;
}

std::string caption(const Analysis& a, std::size_t i) {
  const TrackResult& r = a.recording.main_track().results[i];
  std::string text =
      "frame " + std::to_string(a.recording.frame_index[i]) + ": " + std::string(name(r.state));
  char more[96] = "";
  if (a.has_truth() && a.main_track().errors[i].tracked) {
    const FrameError& e = a.main_track().errors[i];
    text += e.no_open_hand    ? ", but no open hand is there"
            : e.on_other_hand ? ", the other hand"
            : e.wrong         ? ", wrong"
                              : "";
    if (!e.no_open_hand)
      std::snprintf(more, sizeof more, ", tips off by up to %.1f px, pose by %.1f°, %.1f mm",
                    largest_px(e), e.filtered.rotation_deg, e.filtered.translation_mm);
  } else if (a.has_truth() && a.main_track().errors[i].eligible) {
    text += ", though the hand is in view";
  } else if (r.raw_pose) {
    std::snprintf(more, sizeof more, ", residual %.2f px", r.raw_pose->rms_px);
  }
  return text + more;
}

/// Frames to show, each with whether it is one of the worst.
std::map<int, bool> choose(const Analysis& a) {
  const int n = int(a.recording.main_track().results.size());
  std::vector<int> order(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) order[std::size_t(i)] = i;
  std::vector<double> bad;
  for (int i = 0; i < n; ++i) bad.push_back(badness(a, std::size_t(i)));
  std::stable_sort(order.begin(), order.end(),
                   [&](int i, int j) { return bad[std::size_t(i)] > bad[std::size_t(j)]; });
  std::map<int, bool> chosen;
  for (const int i : order) {
    if (int(chosen.size()) == kWorst || bad[std::size_t(i)] <= 0) break;
    const auto near = chosen.lower_bound(i - kApartFrames);
    if (near == chosen.end() || near->first > i + kApartFrames) chosen[i] = true;
  }
  for (int k = 0; k < kSamples && n > 0; ++k)
    chosen.emplace((2 * k + 1) * n / (2 * kSamples), false);
  return chosen;
}

cv::Point fixed_point(const Eigen::Vector2d& px) {
  return {int(std::lround(px.x() * (1 << kSubPixelBits))),
          int(std::lround(px.y() * (1 << kSubPixelBits)))};
}

void draw(cv::Mat& bgr, const Analysis& a, std::size_t i) {
  const TrackResult& r = a.recording.main_track().results[i];
  std::vector<cv::Point> contour;
  for (const Eigen::Vector2f& p : a.recording.contours_px[i])
    contour.push_back(fixed_point(p.cast<double>()));
  if (!contour.empty())
    cv::polylines(bgr, contour, true, {255, 255, 0}, 1, cv::LINE_AA, kSubPixelBits);
  if (r.pose) draw_axes(bgr, a.recording.sequence.camera, r.pose->T_camera_hand);
  if (a.has_truth() && i < a.recording.sequence.truth->frames.size())
    for (const Eigen::Vector2d& tip : a.recording.sequence.truth->frames[i].tips_px)
      for (const double slope : {-1.0, 1.0}) {
        const Eigen::Vector2d arm(6, 6 * slope);
        cv::line(bgr, fixed_point(tip - arm), fixed_point(tip + arm), {255, 255, 255}, 1,
                 cv::LINE_AA, kSubPixelBits);
      }
  if (r.state != State::acquiring && r.state != State::tracking) return;
  for (std::size_t f = 0; f < kFingerCount; ++f) {
    if (!r.tips[f].seen) continue;
    const cv::Point at(int(std::lround(r.tips[f].px.x())), int(std::lround(r.tips[f].px.y())));
    cv::circle(bgr, fixed_point(r.tips[f].px), 5 << kSubPixelBits, {0, 140, 255}, 2, cv::LINE_AA,
               kSubPixelBits);
    cv::putText(bgr, std::string(kFingerNames[f]), at + cv::Point(8, -6), cv::FONT_HERSHEY_SIMPLEX,
                0.45, {0, 0, 0}, 3, cv::LINE_AA);
    cv::putText(bgr, std::string(kFingerNames[f]), at + cv::Point(8, -6), cv::FONT_HERSHEY_SIMPLEX,
                0.45, {255, 255, 255}, 1, cv::LINE_AA);
  }
}

std::vector<unsigned char> jpeg(const cv::Mat& bgr) {
  cv::Mat small;
  cv::resize(bgr, small, {kWidth_px, kWidth_px * bgr.rows / bgr.cols}, 0, 0, cv::INTER_AREA);
  return io::encode_picture(small, ".jpg", "a picture of the report", kJpegQuality);
}

}  // namespace

std::vector<Picture> take_pictures(const Analysis& a) {
  const std::map<int, bool> chosen = choose(a);
  std::vector<Picture> pictures;
  const auto source = io::open_input(a.recording.sequence.video);
  io::Frame frame;
  for (int i = 0; !chosen.empty() && i <= chosen.rbegin()->first; ++i) {
    if (!source->read(frame)) break;
    const auto wanted = chosen.find(i);
    if (wanted == chosen.end()) continue;
    cv::Mat bgr = frame.bgr.clone();
    draw(bgr, a, std::size_t(i));
    pictures.push_back({i, caption(a, std::size_t(i)), wanted->second, jpeg(bgr)});
  }
  return pictures;
}

}  // namespace handyar::evaluation
