// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <opencv2/core.hpp>
#include <vector>

#include "handyar/camera.hpp"

namespace handyar::world {

/// The window of optical flow, and how often the picture is halved for it.
inline const cv::Size kFlowWindow_px{15, 15};
inline constexpr int kFlowLevels = 3;

/// How many pixels are one of a picture whose longer side has 640.
inline double scale_of(const Camera& camera) {
  return std::max(camera.width_px, camera.height_px) / 640.0;
}

/// A grey picture with its pyramid for optical flow.
struct Picture {
  cv::Mat grey;  ///< 8-bit
  std::vector<cv::Mat> pyramid;
  cv::Mat small;  ///< float, one pixel for a square of kSmall of them
};
inline constexpr int kSmall = 8;

Picture make_picture(const cv::Mat& grey);

/// A camera's pose `guess` at the next picture of a video, turned so that the last picture as a
/// whole lies on the next one: where things repeat, patch by patch may lead astray.
Eigen::Isometry3d turned_to_fit(const Picture& last, const Eigen::Isometry3d& T_last_world,
                                const Picture& next, const Eigen::Isometry3d& guess,
                                const Camera& camera);

/// Corners with descriptors, spread over the free part of the picture (255 in `free`; empty: all of
/// it).
struct Corners {
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
};
Corners find_corners(const cv::Mat& grey, const cv::Mat& free);

/// The strongest corners of each part of the picture that is free, without a descriptor: quickly
/// found, to be followed.
std::vector<cv::Point2f> find_spots(const cv::Mat& grey, const cv::Mat& free);

/// In so many sizes corners are looked for.
inline constexpr int kCornerLevels = 4;

/// Descriptors of known corners; those for which there is none are taken out.
cv::Mat describe(const cv::Mat& grey, std::vector<cv::KeyPoint>& corners);

}  // namespace handyar::world
