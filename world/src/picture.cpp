// SPDX-License-Identifier: MIT
#include "picture.hpp"

#include <algorithm>
#include <array>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "handyar/opencv/types.hpp"
#include "rigid.hpp"

namespace handyar::world {
namespace {

constexpr int kMostCorners = 600;
constexpr int kColumns = 10, kRows = 8;  // each cell keeps its best corners
constexpr int kMostInCell = 2 * kMostCorners / (kColumns * kRows);

constexpr int kThreshold = 8;  // low, for tables have little contrast; the cells then choose

cv::Ptr<cv::ORB> orb() {
  constexpr int kCandidates = 2500;
  constexpr float kScale = 1.4f;
  constexpr int kEdge_px = 16, kPatch_px = 31;
  return cv::ORB::create(kCandidates, kScale, kCornerLevels, kEdge_px, 0, 2, cv::ORB::HARRIS_SCORE,
                         kPatch_px, kThreshold);
}

// The strongest of each cell, so that one busy corner of the picture does not have them all.
void spread(std::vector<cv::KeyPoint>& keypoints, cv::Size size, int most_in_cell) {
  std::sort(keypoints.begin(), keypoints.end(), [](const cv::KeyPoint& a, const cv::KeyPoint& b) {
    if (a.response != b.response) return a.response > b.response;
    return a.pt.y != b.pt.y ? a.pt.y < b.pt.y : a.pt.x < b.pt.x;
  });
  std::array<int, kColumns * kRows> taken{};
  std::erase_if(keypoints, [&](const cv::KeyPoint& corner) {
    const int column = static_cast<int>(corner.pt.x) * kColumns / size.width;
    const int row = static_cast<int>(corner.pt.y) * kRows / size.height;
    return ++taken[static_cast<std::size_t>(row * kColumns + column)] > most_in_cell;
  });
}

}  // namespace

Picture make_picture(const cv::Mat& grey) {
  Picture picture;
  picture.grey = grey;
  cv::buildOpticalFlowPyramid(grey, picture.pyramid, kFlowWindow_px, kFlowLevels);
  cv::resize(grey, picture.small, grey.size() / kSmall, 0, 0, cv::INTER_AREA);
  picture.small.convertTo(picture.small, CV_32F);
  return picture;
}

Eigen::Isometry3d turned_to_fit(const Picture& last, const Eigen::Isometry3d& T_last_world,
                                const Picture& next, const Eigen::Isometry3d& guess,
                                const Camera& camera) {
  Eigen::Matrix3d K;  // of the small picture
  K << camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, kSmall;
  const Eigen::Matrix3d H = K * guess.linear() * T_last_world.linear().transpose() * K.inverse();
  cv::Mat H_cv, expected, window;
  cv::eigen2cv(H, H_cv);
  cv::warpPerspective(last.small, expected, H_cv, last.small.size(), cv::INTER_LINEAR,
                      cv::BORDER_REPLICATE);
  cv::createHanningWindow(window, expected.size(), CV_32F);
  const cv::Point2d shift = kSmall * cv::phaseCorrelate(expected, next.small, window);
  Motion turn = Motion::Zero();
  turn.head<2>() << -shift.y / camera.fy_px, shift.x / camera.fx_px;
  return moved(turn, guess);
}

Corners find_corners(const cv::Mat& grey, const cv::Mat& free) {
  Corners corners;
  orb()->detect(grey, corners.keypoints, free);
  spread(corners.keypoints, grey.size(), kMostInCell);
  if (corners.keypoints.size() > kMostCorners) corners.keypoints.resize(kMostCorners);
  corners.descriptors = describe(grey, corners.keypoints);
  return corners;
}

std::vector<cv::Point2f> find_spots(const cv::Mat& grey, const cv::Mat& free) {
  std::vector<cv::KeyPoint> keypoints;
  cv::FastFeatureDetector::create(kThreshold)->detect(grey, keypoints, free);
  constexpr int kSpotsInCell = 3, kMostSpots = 120;
  spread(keypoints, grey.size(), kSpotsInCell);
  if (keypoints.size() > kMostSpots) keypoints.resize(kMostSpots);
  std::vector<cv::Point2f> spots_px;
  cv::KeyPoint::convert(keypoints, spots_px);
  return spots_px;
}

cv::Mat describe(const cv::Mat& grey, std::vector<cv::KeyPoint>& corners) {
  cv::Mat descriptors;
  orb()->compute(grey, corners, descriptors);
  return descriptors;
}

}  // namespace handyar::world
