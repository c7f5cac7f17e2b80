// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core/mat.hpp>

#include "handyar/tracker.hpp"

namespace handyar::cli {

/// Draws what the tracker found in the frame onto it: the hand's contour, the labelled fingertips,
/// the axes of the hand frame, and a line with state, layout and milliseconds. `camera` is the one
/// of this picture size.
void annotate(cv::Mat& bgr, const HandTracker& tracker, const Camera& camera,
              const TrackResult& result);

}  // namespace handyar::cli
