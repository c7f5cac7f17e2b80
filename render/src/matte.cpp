// SPDX-License-Identifier: MIT
#include "matte.hpp"

#include <opencv2/imgproc.hpp>

namespace handyar::render {
namespace {

/// The mask at full size over `region_px`; 0 outside of it.
cv::Mat spread_out(const HandMask& mask, const cv::Rect& region_px) {
  cv::Mat out = cv::Mat::zeros(region_px.size(), CV_8U);
  if (mask.width == 0) return out;
  const cv::Mat small(mask.height, mask.width, CV_8U, const_cast<std::uint8_t*>(mask.data),
                      static_cast<std::size_t>(mask.stride_bytes));
  const cv::Rect covered(mask.x0_px, mask.y0_px, mask.width * mask.step_px,
                         mask.height * mask.step_px);
  const cv::Rect both = covered & region_px;
  if (both.empty()) return out;
  cv::Mat full;
  // Linear, so that a half-size mask has no stairs once its edge is made soft.
  if (mask.step_px == 1)
    full = small;
  else
    cv::resize(small, full, covered.size(), 0, 0, cv::INTER_LINEAR);
  full(both - covered.tl()).copyTo(out(both - region_px.tl()));
  return out;
}

}  // namespace

cv::Mat hand_matte(const HandMask& mask, const cv::Rect& region_px, double rounding_px) {
  // Neighbours of the region count for the pixels at its border.
  const int border = std::min(32, 4 + static_cast<int>(std::ceil(rounding_px)));
  const cv::Rect wide(region_px.x - border, region_px.y - border, region_px.width + 2 * border,
                      region_px.height + 2 * border);
  cv::Mat coverage = spread_out(mask, wide), binary, depth_px, rounding;
  cv::threshold(coverage, binary, 127, 255, cv::THRESH_BINARY);
  cv::distanceTransform(binary, depth_px, cv::DIST_L2, 3);
  depth_px.convertTo(rounding, CV_8U, 255.0 / std::max(rounding_px, 1.0));
  // Half covered where the blurred mask is 0.6, a fraction of a pixel inside its edge.
  cv::GaussianBlur(coverage, coverage, {}, 1.3);
  coverage.convertTo(coverage, CV_8U, 2.0, 127.5 - 2.0 * 0.6 * 255);
  cv::Mat both;
  cv::merge(std::vector<cv::Mat>{coverage, rounding}, both);
  return both({border, border, region_px.width, region_px.height}).clone();
}

}  // namespace handyar::render
