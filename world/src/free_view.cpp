// SPDX-License-Identifier: MIT
#include "free_view.hpp"

#include <opencv2/imgproc.hpp>
#include <vector>

#include "handyar/opencv/lens.hpp"

namespace handyar::world {
namespace {

constexpr int kAround_px = 11;  // the figure's outline may be off, and patches reach out

// A strip from the palm along the forearm, as far as it lies before the camera.
void hide_forearm(cv::Mat& free, const Eigen::Isometry3d& T_camera_hand, const Camera& camera) {
  constexpr double kHalfWidth_m = 0.055, kHalfWidthAtElbow_m = 0.08;
  constexpr double kFrom_m = -0.02, kTo_m = -0.45, kStep_m = 0.01;
  std::vector<cv::Point> left, right;
  for (double y_m = kFrom_m; y_m > kTo_m; y_m -= kStep_m) {
    const double along = (y_m - kFrom_m) / (kTo_m - kFrom_m);
    const double half_m = kHalfWidth_m + along * (kHalfWidthAtElbow_m - kHalfWidth_m);
    const Eigen::Vector3d a = T_camera_hand * Eigen::Vector3d(-half_m, y_m, 0);
    const Eigen::Vector3d b = T_camera_hand * Eigen::Vector3d(half_m, y_m, 0);
    if (a.z() < 0.05 || b.z() < 0.05) break;
    const auto a_px = shown_at(camera, a), b_px = shown_at(camera, b);
    if (!a_px || !b_px) break;
    if (a_px->cwiseAbs().maxCoeff() > 1e4 || b_px->cwiseAbs().maxCoeff() > 1e4) break;
    left.emplace_back(static_cast<int>(a_px->x()), static_cast<int>(a_px->y()));
    right.emplace_back(static_cast<int>(b_px->x()), static_cast<int>(b_px->y()));
  }
  left.insert(left.end(), right.rbegin(), right.rend());
  if (left.size() > 2) cv::fillPoly(free, std::vector<std::vector<cv::Point>>{left}, 0);
}

}  // namespace

cv::Mat free_of_hand(const HandInWorld& hand, const Camera& camera) {
  if (hand.mask.width == 0) return {};
  cv::Mat free(camera.height_px, camera.width_px, CV_8U, cv::Scalar(255));
  const cv::Mat mask(hand.mask.height, hand.mask.width, CV_8U,
                     const_cast<std::uint8_t*>(hand.mask.data),
                     static_cast<std::size_t>(hand.mask.stride_bytes));
  const cv::Rect covers(hand.mask.x0_px, hand.mask.y0_px, hand.mask.width * hand.mask.step_px,
                        hand.mask.height * hand.mask.step_px);
  const cv::Rect in_picture = covers & cv::Rect(0, 0, free.cols, free.rows);
  cv::Mat grown;
  cv::resize(mask, grown, covers.size(), 0, 0, cv::INTER_NEAREST);
  free(in_picture).setTo(0, grown(in_picture - covers.tl()));
  cv::erode(free, free,
            cv::getStructuringElement(cv::MORPH_RECT, {2 * kAround_px + 1, 2 * kAround_px + 1}));
  if (hand.T_camera_hand) hide_forearm(free, *hand.T_camera_hand, camera);
  return free;
}

}  // namespace handyar::world
