// SPDX-License-Identifier: MIT
#include "handyar/opencv/annotate.hpp"

#include <algorithm>
#include <cstdio>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "handyar/opencv/lens.hpp"

namespace handyar {
namespace {

constexpr int kSubpixelBits =
    4;  // OpenCV draws at fractions of a pixel when given them as integers

// Okabe and Ito's colours, which differ for the colour-blind too; blue, green, red.
const cv::Scalar kFingerColors[kFingerCount] = {
    {0, 159, 230}, {233, 180, 86}, {66, 228, 240}, {167, 121, 204}, {115, 158, 0}};
const cv::Scalar kWhite{255, 255, 255}, kShadow{20, 20, 20};
const cv::Scalar kContour{255, 255, 255};
constexpr double kAxisLength_m = 0.04;

cv::Point fixed(const Eigen::Vector2d& px) {
  const double scale = 1 << kSubpixelBits;
  return {cvRound(px.x() * scale), cvRound(px.y() * scale)};
}

// All sizes follow the picture's, so that a large frame is as legible as a small one.
struct Pen {
  cv::Mat& picture;
  double unit;  ///< 1 at 640x480
  bool mirrored = false;

  int thick(double width) const { return std::max(1, cvRound(width * unit)); }

  void line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const cv::Scalar& color,
            double width) const {
    cv::line(picture, fixed(a), fixed(b), kShadow, thick(width + 2), cv::LINE_AA, kSubpixelBits);
    cv::line(picture, fixed(a), fixed(b), color, thick(width), cv::LINE_AA, kSubpixelBits);
  }

  void dot(const Eigen::Vector2d& at, double radius, const cv::Scalar& color) const {
    const double scale = unit * (1 << kSubpixelBits);
    cv::circle(picture, fixed(at), cvRound((radius + 1.5) * scale), kShadow, cv::FILLED,
               cv::LINE_AA, kSubpixelBits);
    cv::circle(picture, fixed(at), cvRound(radius * scale), color, cv::FILLED, cv::LINE_AA,
               kSubpixelBits);
  }

  cv::Size size_of(const std::string& text, double size) const {
    return cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, size * unit, thick(1), nullptr);
  }

  // `at`: left end of the base line; moved so that the text stays in the picture.
  void text(const std::string& text, cv::Point at, double size, const cv::Scalar& color) const {
    const cv::Size box = size_of(text, size);
    const int margin = thick(3);
    at.x = std::max(margin, std::min(at.x, picture.cols - box.width - margin));
    at.y = std::max(box.height + margin, std::min(at.y, picture.rows - margin));
    // In a picture that will be mirrored its strip is mirrored for as long as it is written on.
    const cv::Range rows(std::max(0, at.y - box.height - margin),
                         std::min(picture.rows, at.y + box.height));
    const cv::Range cols(std::max(0, at.x - margin),
                         std::min(picture.cols, at.x + box.width + margin));
    cv::Mat strip = picture(rows, cols);
    if (mirrored) cv::flip(strip, strip, 1);
    at -= cv::Point(cols.start, rows.start);
    cv::putText(strip, text, at, cv::FONT_HERSHEY_SIMPLEX, size * unit, kShadow, thick(3),
                cv::LINE_AA);
    cv::putText(strip, text, at, cv::FONT_HERSHEY_SIMPLEX, size * unit, color, thick(1),
                cv::LINE_AA);
    if (mirrored) cv::flip(strip, strip, 1);
  }

  void centered_text(const std::string& label, const Eigen::Vector2d& center, double size,
                     const cv::Scalar& color) const {
    const cv::Size box = size_of(label, size);
    text(label, {cvRound(center.x()) - box.width / 2, cvRound(center.y()) + box.height / 2}, size,
         color);
  }
};

Pen pen_for(cv::Mat& bgr, bool mirrored = false) {
  return {bgr, std::max(0.6, std::min(bgr.cols / 640.0, bgr.rows / 480.0)), mirrored};
}

void draw_contour(const Pen& pen, const HandMask& mask) {
  if (mask.width == 0) return;
  const cv::Mat pixels(mask.height, mask.width, CV_8U, const_cast<std::uint8_t*>(mask.data),
                       static_cast<std::size_t>(mask.stride_bytes));
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(pixels, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_SIMPLE);
  for (auto& outline : outlines) {
    for (cv::Point& p : outline)
      p = fixed({mask.x0_px + p.x * mask.step_px, mask.y0_px + p.y * mask.step_px});
    cv::polylines(pen.picture, outline, true, kShadow, pen.thick(3), cv::LINE_AA, kSubpixelBits);
    cv::polylines(pen.picture, outline, true, kContour, pen.thick(1), cv::LINE_AA, kSubpixelBits);
  }
}

void draw_tips(const Pen& pen, const TrackResult& result) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  int seen = 0;
  for (const Tip& tip : result.tips) {
    if (!tip.known()) continue;
    mean += tip.px;
    ++seen;
  }
  if (seen == 0) return;
  mean /= seen;
  for (std::size_t i = 0; i < result.tips.size(); ++i) {
    const Tip& tip = result.tips[i];
    if (!tip.known()) continue;
    pen.dot(tip.px, tip.seen ? 4 : 2, kFingerColors[i]);
    // The label stands beyond the fingertip, where no hand is.
    Eigen::Vector2d away = tip.px - mean + Eigen::Vector2d(0, -0.5 * (tip.px - mean).norm());
    away = away.norm() > 1 ? away.normalized().eval() : Eigen::Vector2d(0, -1);
    const Eigen::Vector2d label = tip.px + pen.unit * away.cwiseProduct(Eigen::Vector2d(30, 17));
    pen.centered_text(std::string(kFingerNames[i]), label, 0.42, kFingerColors[i]);
  }
}

void draw_axes(const Pen& pen, const Camera& camera, const Eigen::Isometry3d& T_camera_hand) {
  const cv::Scalar colors[3] = {{70, 70, 235}, {90, 200, 80}, {240, 140, 60}};  // x, y, z
  const char* const names[3] = {"x", "y", "z"};
  const Eigen::Vector3d origin = T_camera_hand.translation();
  if (origin.z() <= 2 * kAxisLength_m) return;
  const auto origin_px = shown_at(camera, origin);
  if (!origin_px) return;
  int order[3] = {0, 1, 2};  // the axis that points at the camera lies over the others
  std::sort(order, order + 3, [&](int a, int b) {
    return T_camera_hand.linear()(2, a) > T_camera_hand.linear()(2, b);
  });
  for (const int axis : order) {
    const Eigen::Vector3d end = origin + kAxisLength_m * T_camera_hand.linear().col(axis);
    const auto end_px = shown_at(camera, end);
    if (!end_px) continue;
    pen.line(*origin_px, *end_px, colors[axis], 2.5);
    const Eigen::Vector2d along = *end_px - *origin_px;
    if (along.norm() < 6 * pen.unit) continue;
    pen.centered_text(names[axis], *end_px + 10 * pen.unit * along.normalized(), 0.45,
                      colors[axis]);
  }
  pen.dot(*origin_px, 3, kWhite);
}

std::string status_line(const TrackResult& result, bool mirrored, const std::string& missing,
                        bool brief) {
  std::string line(name(result.state));
  if (result.gesture != Gesture::open) line = name(result.gesture);
  if (result.doubtful) line += " (doubtful)";
  if (result.layout)
    line += "   " + std::string(name(mirrored ? opposite(*result.layout) : *result.layout));
  if (result.state != State::tracking && !result.held_pose && !missing.empty())
    return line + "   " + missing;
  char text[96];
  if (result.pose) {
    std::snprintf(text, sizeof text, "   %.0f mm%s",
                  1000 * result.pose->T_camera_hand.translation().norm(),
                  result.scale_assumed && !brief ? " (assumed scale)" : "");
    line += text;
  }
  if (result.times.total_ms > 0 && !brief) {
    std::snprintf(text, sizeof text, "   %.2f ms", result.times.total_ms);
    line += text;
  }
  std::replace(line.begin(), line.end(), '_', ' ');
  return line;
}

// A darkened band at the bottom: text on it is legible before any background. Of several hands each
// has its part of it, with fewer words, from left to right as they are looked at.
void draw_status(const Pen& pen, std::span<const AnnotatedHand> hands, const std::string& missing) {
  static const cv::Scalar colors[] = {
      {190, 190, 190}, {60, 200, 250}, {110, 220, 120}, {80, 100, 240}};  // as in State
  const int height = pen.thick(26), width = pen.picture.cols;
  cv::Mat band = pen.picture.rowRange(pen.picture.rows - height, pen.picture.rows);
  band *= 0.35;
  const double y = pen.picture.rows - 0.5 * height;
  for (std::size_t i = 0; i < hands.size(); ++i) {
    const TrackResult& result = hands[i].result;
    const int left = static_cast<int>(i) * width / static_cast<int>(hands.size());
    const auto across = [&](double x) { return pen.mirrored ? width - 1 - x : x; };
    pen.dot({across(left + 14 * pen.unit), y}, 5, colors[static_cast<std::size_t>(result.state)]);
    const std::string line = status_line(result, pen.mirrored, missing, hands.size() > 1);
    int x = left + pen.thick(28);
    if (pen.mirrored) x = width - x - pen.size_of(line, 0.48).width;
    pen.text(line, {x, cvRound(y + 5 * pen.unit)}, 0.48, kWhite);
  }
}

}  // namespace

void draw_contour(cv::Mat& bgr, const HandMask& mask) { draw_contour(pen_for(bgr), mask); }
void draw_tips(cv::Mat& bgr, const TrackResult& result) { draw_tips(pen_for(bgr), result); }
void draw_axes(cv::Mat& bgr, const Camera& camera, const Eigen::Isometry3d& T_camera_hand) {
  draw_axes(pen_for(bgr), camera, T_camera_hand);
}

void annotate(cv::Mat& bgr, std::span<const AnnotatedHand> hands, const Camera& camera,
              bool mirrored, const std::string& missing) {
  const Pen pen = pen_for(bgr, mirrored);
  for (const auto& [mask, result] : hands) {
    draw_contour(pen, mask);
    if (result.pose) draw_axes(pen, camera, result.pose->T_camera_hand);
    draw_tips(pen, result);
  }
  draw_status(pen, hands, missing);
}

void annotate(cv::Mat& bgr, const HandMask& mask, const Camera& camera, const TrackResult& result,
              bool mirrored, const std::string& missing) {
  const AnnotatedHand hand{mask, result};
  annotate(bgr, {&hand, 1}, camera, mirrored, missing);
}

void draw_lines(cv::Mat& bgr, const std::vector<std::string>& lines) {
  const Pen pen = pen_for(bgr);
  const int step = pen.thick(24), margin = pen.thick(14);
  constexpr double kSize = 0.48;
  int width = 0;
  for (const std::string& line : lines)
    width = std::max(width, pen.size_of(line, kSize).width + 2 * margin);
  const int height = step * (static_cast<int>(lines.size()) + 1) - step / 3;
  cv::Mat panel = bgr(cv::Rect(0, 0, std::min(width, bgr.cols), std::min(height, bgr.rows)));
  panel *= 0.35;
  for (std::size_t i = 0; i < lines.size(); ++i)
    pen.text(lines[i], {margin, step * (static_cast<int>(i) + 1)}, kSize, kWhite);
}

}  // namespace handyar
