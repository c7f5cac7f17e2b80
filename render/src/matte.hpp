// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core.hpp>

#include "handyar/tracker.hpp"

namespace handyar::render {

/// How the hand covers a part of the frame: 8-bit, two channels of the size of `region_px`.
/// First: coverage, 0 none .. 255 full, with a soft edge just inside the mask so that no background
/// comes along. Second: how far inside the silhouette, 0 at its edge .. 255 at `rounding_px` and
/// deeper; a finger's surface falls away towards its edge by this much.
cv::Mat hand_matte(const HandMask& mask, const cv::Rect& region_px, double rounding_px);

}  // namespace handyar::render
