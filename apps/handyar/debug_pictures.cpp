// SPDX-License-Identifier: MIT
#include "debug_pictures.hpp"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <opencv2/imgproc.hpp>

#include "handyar/io/picture_file.hpp"
#include "handyar/opencv/annotate.hpp"
#include "handyar/stages/evidence.hpp"

namespace handyar::cli {
namespace {

const cv::Scalar kSure{110, 220, 120}, kUnsure{80, 100, 240}, kCandidate{66, 228, 240};

cv::Point2d point(const Eigen::Vector2f& px) { return {px.x(), px.y()}; }

/// Where the finder saw hands: palm and rough fingertips, the surer the thicker.
void draw_candidates(cv::Mat& picture, std::span<const HandCandidate> candidates) {
  for (const HandCandidate& candidate : candidates) {
    const int thickness = candidate.log_odds > 0 ? 2 : 1;
    for (int f = 0; f < kFingerCount; ++f) {
      const cv::Point root = point(candidate.roots_px[f]), tip = point(candidate.tips_px[f]);
      cv::line(picture, point(candidate.palm_px), root, kCandidate, thickness, cv::LINE_AA);
      cv::line(picture, root, tip, kCandidate, thickness, cv::LINE_AA);
      cv::circle(picture, tip, 4, kCandidate, thickness, cv::LINE_AA);
    }
  }
}

/// Each place on the figure's outline and the line to where the picture has its boundary; green
/// where the picture agrees, red where it does not.
void draw_outline(cv::Mat& picture, std::span<const OutlinePoint> outline) {
  for (const OutlinePoint& p : outline) {
    const cv::Scalar& color = p.log_ratio > 0 ? kSure : kUnsure;
    cv::circle(picture, point(p.px), 2, color, cv::FILLED, cv::LINE_AA);
    cv::line(picture, point(p.px), point(p.px + p.found_px * p.normal), color, 1, cv::LINE_AA);
  }
}

cv::Mat region(const cv::Mat& bgr, const HandMask& mask) {
  cv::Mat picture = 0.3 * bgr;
  for (int v = 0; v < mask.height; ++v)
    for (int u = 0; u < mask.width; ++u)
      if (mask.data[v * mask.stride_bytes + u] != 0) {
        const cv::Rect pixel(mask.x0_px + u * mask.step_px, mask.y0_px + v * mask.step_px,
                             mask.step_px, mask.step_px);
        const cv::Rect inside = pixel & cv::Rect({}, bgr.size());
        bgr(inside).copyTo(picture(inside));
      }
  return picture;
}

}  // namespace

bool FrameSet::contains(std::int64_t frame) const noexcept {
  return ranges.empty() || std::ranges::any_of(ranges, [&](const auto& range) {
           return range.first <= frame && frame <= range.second;
         });
}

std::int64_t FrameSet::last() const noexcept {
  std::int64_t last = 0;
  for (const auto& range : ranges) last = std::max(last, range.second);
  return last;
}

std::optional<FrameSet> parse_frames(const std::string& text) {
  FrameSet frames;
  const char *at = text.data(), *const end = at + text.size();
  const auto number = [&](std::int64_t& value) {
    const auto [next, fault] = std::from_chars(at, end, value);
    at = next;
    return fault == std::errc() && value >= 0;
  };
  while (true) {
    std::int64_t first = 0, last = 0;
    if (!number(first)) return std::nullopt;
    last = first;
    if (at != end && *at == '-' && (++at, !number(last))) return std::nullopt;
    if (last < first) return std::nullopt;
    frames.ranges.emplace_back(first, last);
    if (at == end) return frames;
    if (*at++ != ',') return std::nullopt;
  }
}

void DebugPictures::save(const cv::Mat& picture, const char* stage) const {
  char name[64];
  std::snprintf(name, sizeof name, "frame_%06lld_%s.png", static_cast<long long>(frame_), stage);
  io::write_picture(folder_.file(name), picture);
}

void DebugPictures::write(const cv::Mat& bgr, std::int64_t frame, const AnyTracker& tracker,
                          const Camera& camera, const TrackResult& result) {
  frame_ = frame;
  save(bgr, "1_input");
  if (const FrameEvidence* evidence = tracker.evidence()) {
    cv::Mat picture = bgr.clone();
    draw_candidates(picture, evidence->candidates);
    if (!evidence->candidates.empty()) save(picture, "2_candidates");
    picture = 0.7 * bgr;
    draw_outline(picture, evidence->outline);
    if (!evidence->outline.empty()) save(picture, "3_outline");
  }
  const HandMask mask = tracker.mask();
  if (mask.width == 0) return;
  save(region(bgr, mask), "4_region");
  cv::Mat picture = bgr.clone();
  draw_tips(picture, result);
  if (result.pose) draw_axes(picture, camera, result.pose->T_camera_hand);
  save(picture, "5_pose");
}

}  // namespace handyar::cli
