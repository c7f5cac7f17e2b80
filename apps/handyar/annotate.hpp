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

/// Its parts, alone.
void draw_contour(cv::Mat& bgr, std::span<const Eigen::Vector2f> contour_px);
void draw_tips(cv::Mat& bgr, const TrackResult& result);
void draw_axes(cv::Mat& bgr, const Camera& camera, const Eigen::Isometry3d& T_camera_hand);

}  // namespace handyar::cli
