// SPDX-License-Identifier: MIT
#include "hand_at_rest.hpp"

#include <algorithm>
#include <opencv2/video/tracking.hpp>

#include "free_view.hpp"
#include "matching.hpp"

namespace handyar::world {
namespace {

constexpr double kRest_s = 0.5;
constexpr double kStill_px = 4;  // see scale_of()
constexpr std::size_t kFewest = 15;

}  // namespace

HandAtRest::Rest HandAtRest::update(const Picture& picture, double time_s, const HandInWorld& hand,
                                    const cv::Mat& free, const Camera& camera) {
  if (!hand.T_camera_hand) {
    start_.reset();
    return Rest::no;
  }
  if (!start_ || !still(picture, hand, free, camera))
    return begin(picture, time_s, hand, free) ? Rest::lying : Rest::no;
  if (time_s - start_->time_s < kRest_s) return Rest::lying;
  start_.reset();
  return Rest::lain;
}

bool HandAtRest::begin(const Picture& picture, double time_s, const HandInWorld& hand,
                       const cv::Mat& free) {
  start_.reset();
  std::vector<cv::Point2f> corners_px = find_spots(picture.grey, free);
  if (corners_px.size() < kFewest) return false;
  now_px_ = corners_px;
  start_ = Start{picture, time_s, *hand.T_camera_hand, std::move(corners_px)};
  return true;
}

bool HandAtRest::still(const Picture& picture, const HandInWorld& hand, const cv::Mat& free,
                       const Camera& camera) {
  std::vector<std::uint8_t> found;
  cv::calcOpticalFlowPyrLK(start_->picture.pyramid, picture.pyramid, start_->corners_px, now_px_,
                           found, cv::noArray(), kFlowWindow_px, kFlowLevels,
                           {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 15, 0.03},
                           cv::OPTFLOW_USE_INITIAL_FLOW);
  const Eigen::Hyperplane<double, 3> plane(Eigen::Vector3d::UnitZ(), hand.thickness_m);
  std::vector<double> errors_px;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (!found[i]) continue;
    const Eigen::Vector2d was(start_->corners_px[i].x, start_->corners_px[i].y);
    const Eigen::Vector2d is(now_px_[i].x, now_px_[i].y);
    const auto p = on_ground(was, {camera, start_->T_camera_hand}, plane);
    if (!p) continue;
    const auto predicted = pixel_of(*p, {camera, *hand.T_camera_hand});
    if (predicted && is_free(free, *predicted)) errors_px.push_back((is - *predicted).norm());
  }
  if (errors_px.size() < kFewest) return false;
  const auto middle = errors_px.begin() + static_cast<std::ptrdiff_t>(errors_px.size() / 2);
  std::nth_element(errors_px.begin(), middle, errors_px.end());
  return *middle < kStill_px * scale_of(camera);
}

}  // namespace handyar::world
