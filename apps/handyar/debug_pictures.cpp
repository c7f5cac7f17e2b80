// SPDX-License-Identifier: MIT
#include "debug_pictures.hpp"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <opencv2/imgproc.hpp>

#include "annotate.hpp"
#include "handyar/hand_shape.hpp"
#include "handyar/io/picture_file.hpp"

namespace handyar::cli {
namespace {

const cv::Scalar kTipColor{66, 228, 240}, kValleyColor{180, 105, 0}, kEllipseColor{80, 60, 230};

/// Mid-grey: as likely hand as background; four levels are an eighth of a nat.
cv::Mat likelihood(const cv::Mat& bgr, std::span<const std::int8_t> ratios) {
  BinImage image;
  image.bins.resize(bgr.total());
  const ImageView view{bgr.data, bgr.cols, bgr.rows, std::ptrdiff_t(bgr.step[0]), PixelFormat::bgr};
  read_bins(view, {0, 0, bgr.cols, bgr.rows}, 1, image);
  cv::Mat picture(bgr.size(), CV_8U);
  std::ranges::transform(image.used(), picture.data, [&](ColorBin bin) {
    return cv::saturate_cast<std::uint8_t>(128 + 4 * ratios[bin]);
  });
  return picture;
}

/// The tracker's mask in the form that the stages want.
Mask packed(const HandMask& from) {
  Mask mask;
  mask.pack(from.data, from.width, from.height, from.stride_bytes);
  return mask;
}

/// The hand of a result in mask pixels.
HandShape shape_of(const TrackResult& result, const HandMask& mask) {
  HandShape shape;
  const auto to_mask = [&](const Eigen::Vector2d& px) -> Eigen::Vector2f {
    const double centre = 0.5 * (mask.step_px - 1);
    return ((px - Eigen::Vector2d(mask.x0_px + centre, mask.y0_px + centre)) / mask.step_px)
        .cast<float>();
  };
  shape.layout = *result.layout;
  for (int f = 0; f < kFingerCount; ++f) {
    shape.tip_seen[f] = result.tips[f].seen;
    shape.tips[f] = to_mask(result.tips[f].px);
  }
  for (int k = 0; k < kValleyCount; ++k) {
    shape.valley_seen[k] = result.valleys[k].seen;
    shape.valleys[k] = to_mask(result.valleys[k].px);
  }
  HandShapeModel{}.fit({}, shape);
  return shape;
}

/// The stages from mask to fingertips once more, for what the tracker does not keep of them.
struct Stages {
  HandMask hand_mask;
  Mask mask;
  HandShape shape;
  Contour contour;
  CurvatureFinder curvature;

  Stages(const HandTracker& tracker, const FingertipConfig& config, const TrackResult& result)
      : hand_mask(tracker.mask()),
        mask(packed(hand_mask)),
        shape(shape_of(result, hand_mask)),
        curvature(config) {
    contour.reserve(1 << 14);
    if (contour.trace(mask)) curvature.find(contour, shape.palm_radius());
  }
  Eigen::Vector2d to_input(const Eigen::Vector2f& p) const {
    const double centre = 0.5 * (hand_mask.step_px - 1);
    return hand_mask.step_px * p.cast<double>() +
           Eigen::Vector2d(hand_mask.x0_px + centre, hand_mask.y0_px + centre);
  }
};

cv::Mat region(const cv::Mat& bgr, const HandMask& mask) {
  cv::Mat picture = 0.3 * bgr;
  for (int v = 0; v < mask.height; ++v)
    for (int u = 0; u < mask.width; ++u)
      if (mask.data[v * mask.stride_bytes + u] != 0) {
        const cv::Rect pixel(mask.x0_px + u * mask.step_px, mask.y0_px + v * mask.step_px,
                             mask.step_px, mask.step_px);
        bgr(pixel).copyTo(picture(pixel));
      }
  cv::rectangle(picture,
                {mask.x0_px, mask.y0_px, mask.width * mask.step_px, mask.height * mask.step_px},
                kTipColor);
  return picture;
}

cv::Point2d point(const Eigen::Vector2d& px) { return {px.x(), px.y()}; }

/// Every place that turns as sharply as a fingertip, and the valleys between the hand's fingers.
void draw_extrema(cv::Mat& picture, const Stages& stages, const TrackResult& result) {
  for (const Extremum& tip : stages.curvature.tips())
    cv::circle(picture, point(stages.to_input(tip.at)), 6, kTipColor, 2, cv::LINE_AA);
  for (const Tip& valley : result.valleys)
    if (valley.seen)
      cv::drawMarker(picture, point(valley.px), kValleyColor, cv::MARKER_SQUARE, 11, 3,
                     cv::LINE_AA);
}

/// The ellipse around each fingertip and the tip that was measured with it.
void draw_ellipses(cv::Mat& picture, const Stages& stages, const TrackResult& result) {
  for (const Extremum& tip : stages.curvature.tips()) {
    Ellipse ellipse;
    const float arc = float(tip.sample) * stages.curvature.spacing();
    const bool used = std::ranges::any_of(result.tips, [&](const Tip& t) {
      return t.seen && (t.px - stages.to_input(tip.at)).norm() <
                           stages.hand_mask.step_px * stages.shape.finger_width;
    });
    if (!used || !fit_tip_ellipse(stages.contour, arc, stages.shape.finger_width, ellipse))
      continue;
    const double angle_deg = std::atan2(ellipse.axis.y(), ellipse.axis.x()) * 180 / CV_PI;
    const double size = 2.0 * stages.hand_mask.step_px;
    cv::ellipse(
        picture,
        cv::RotatedRect(point(stages.to_input(ellipse.center)),
                        cv::Size2d(size * ellipse.major, size * ellipse.minor), float(angle_deg)),
        kEllipseColor, 2, cv::LINE_AA);
  }
}

void draw_axes(cv::Mat& picture, const TrackResult& result) {
  for (const FingerAxis& axis : result.axes)
    if (axis.seen)
      cv::line(picture, point(axis.end_px), point(axis.root_px), kValleyColor, 2, cv::LINE_AA);
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

void DebugPictures::prepare(const HandTracker& tracker) {
  const auto ratios = tracker.color_ratios();
  ratios_.assign(ratios.begin(), ratios.end());
}

void DebugPictures::save(const cv::Mat& picture, const char* stage) const {
  char name[64];
  std::snprintf(name, sizeof name, "frame_%06lld_%s.png", static_cast<long long>(frame_), stage);
  io::write_picture(folder_.file(name), picture);
}

void DebugPictures::write(const cv::Mat& bgr, std::int64_t frame, const HandTracker& tracker,
                          const FingertipConfig& fingertips, const Camera& camera,
                          const TrackResult& result) {
  frame_ = frame;
  save(bgr, "1_input");
  save(likelihood(bgr, ratios_), "2_likelihood");
  if (tracker.mask().width == 0 || !result.layout) return;
  const Stages stages(tracker, fingertips, result);
  save(region(bgr, stages.hand_mask), "3_region");
  cv::Mat picture = 0.5 * bgr;
  draw_contour(picture, tracker.contour_px());
  cv::Mat with_extrema = picture.clone();
  draw_extrema(with_extrema, stages, result);
  save(with_extrema, "4_contour");
  draw_axes(picture, result);
  draw_ellipses(picture, stages, result);
  draw_tips(picture, result);
  save(picture, "5_fingertips");
  if (!result.pose) return;
  picture = bgr.clone();
  draw_tips(picture, result);
  draw_axes(picture, camera, result.pose->T_camera_hand);
  save(picture, "6_pose");
}

}  // namespace handyar::cli
