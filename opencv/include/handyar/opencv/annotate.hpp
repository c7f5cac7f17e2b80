// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core/mat.hpp>
#include <span>
#include <string>
#include <vector>

#include "handyar/tracker.hpp"

namespace handyar {

/// Draws what the tracker found in the frame onto it: the hand's contour, the labelled fingertips,
/// the axes of the hand frame, and a line with state, layout and milliseconds, and `missing` when
/// there is no hand. `camera` is the one of this picture size. `mirrored`: the picture will be
/// mirrored, so that all words are written from right to left and the layout is the mirror's.
void annotate(cv::Mat& bgr, const HandMask& mask, const Camera& camera, const TrackResult& result,
              bool mirrored = false, const std::string& missing = "");

/// A hand in a frame as one of two trackers found it.
struct AnnotatedHand {
  HandMask mask;
  const TrackResult& result;
};

/// The same for the hands of a frame; their words stand beside each other.
void annotate(cv::Mat& bgr, std::span<const AnnotatedHand> hands, const Camera& camera,
              bool mirrored = false, const std::string& missing = "");

/// Writes lines of text into the picture's upper left corner.
void draw_lines(cv::Mat& bgr, const std::vector<std::string>& lines);

/// Its parts, alone.
void draw_contour(cv::Mat& bgr, const HandMask& mask);
void draw_tips(cv::Mat& bgr, const TrackResult& result);
void draw_axes(cv::Mat& bgr, const Camera& camera, const Eigen::Isometry3d& T_camera_hand);

}  // namespace handyar
