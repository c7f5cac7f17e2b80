// SPDX-License-Identifier: MIT
#include "hand_at_rest.hpp"

#include <algorithm>
#include <opencv2/video/tracking.hpp>

#include "free_view.hpp"
#include "matching.hpp"

namespace handyar::world {
namespace {

constexpr double kRest_s = 0.5, kGoesWell_s = 0.25;
constexpr double kStill_px = 4;  // see scale_of()
constexpr std::size_t kFewest = 15;

// How much deeper than the hand the surroundings are tried, in parts of the hand's distance, and
// how much better they must fit there. Deeper yet, still surroundings and a hand that moves before
// them look the same.
constexpr double kDeeper[] = {0.15, 0.3, 0.6, 1.2}, kBetter = 0.25;

Eigen::Hyperplane<double, 3> plane_at(double depth_m) {
  return {Eigen::Vector3d::UnitZ(), depth_m};
}

/// Corners of a picture, and where they have gone as far as that was found.
struct Moved {
  const std::vector<cv::Point2f>&from_px, &to_px;
  const std::vector<std::uint8_t>& found;
};

Eigen::Vector2d vector(const cv::Point2f& p) { return {p.x, p.y}; }

/// By how much corners are off, in the middle, when the camera goes from `from` to `to` and they
/// lie on a plane; empty when too few can be told.
std::optional<double> error_px(const Moved& corners, const View& from, const View& to,
                               const Eigen::Hyperplane<double, 3>& plane, const cv::Mat& free) {
  std::vector<double> errors_px;
  for (std::size_t i = 0; i < corners.from_px.size(); ++i) {
    if (!corners.found[i]) continue;
    const auto p = on_ground(vector(corners.from_px[i]), from, plane);
    if (!p) continue;
    const auto predicted = pixel_of(*p, to);
    if (predicted && is_free(free, *predicted))
      errors_px.push_back((vector(corners.to_px[i]) - *predicted).norm());
  }
  if (errors_px.size() < kFewest) return std::nullopt;
  const auto middle = errors_px.begin() + static_cast<std::ptrdiff_t>(errors_px.size() / 2);
  std::nth_element(errors_px.begin(), middle, errors_px.end());
  return *middle;
}

}  // namespace

HandAtRest::Rest HandAtRest::update(const Picture& picture, double time_s, const HandInWorld& hand,
                                    const cv::Mat& free, const Camera& camera) {
  if (!hand.T_camera_hand) {
    start_.reset();
    hindrance_ = hand.mask.width > 0 ? Hindrance::unsure : Hindrance::no_hand;
    return Rest::no;
  }
  if (hindrance_ == Hindrance::no_hand) hindrance_.reset();
  if (start_) {
    if (const auto fault = go_on(picture, hand, free, camera)) {
      hindrance_ = fault;
      start_.reset();
    }
  }
  if (!start_) {
    const auto fault = begin(picture, time_s, hand, free, camera);
    if (fault) hindrance_ = fault;
    return fault ? Rest::no : Rest::lying;
  }
  if (time_s - start_->time_s >= kGoesWell_s) hindrance_.reset();
  if (time_s - start_->time_s < kRest_s) return Rest::lying;
  start_.reset();
  return Rest::lain;
}

std::optional<Hindrance> HandAtRest::begin(const Picture& picture, double time_s,
                                           const HandInWorld& hand, const cv::Mat& free,
                                           const Camera& camera) {
  std::vector<cv::Point2f> corners_px = find_spots(picture.grey, free);
  if (corners_px.size() < kFewest) return Hindrance::bare;
  const View view{camera, *hand.T_camera_hand};
  const auto on_plane = std::count_if(corners_px.begin(), corners_px.end(), [&](const auto& px) {
    return on_ground(vector(px), view, plane_at(hand.thickness_m)).has_value();
  });
  if (static_cast<std::size_t>(on_plane) < kFewest) return Hindrance::tilted;
  now_px_ = corners_px;
  start_ = Start{picture, time_s, *hand.T_camera_hand, std::move(corners_px)};
  return std::nullopt;
}

std::optional<Hindrance> HandAtRest::go_on(const Picture& picture, const HandInWorld& hand,
                                           const cv::Mat& free, const Camera& camera) {
  std::vector<std::uint8_t> found;
  cv::calcOpticalFlowPyrLK(start_->picture.pyramid, picture.pyramid, start_->corners_px, now_px_,
                           found, cv::noArray(), kFlowWindow_px, kFlowLevels,
                           {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 15, 0.03},
                           cv::OPTFLOW_USE_INITIAL_FLOW);
  const Moved corners{start_->corners_px, now_px_, found};
  const View from{camera, start_->T_camera_hand}, to{camera, *hand.T_camera_hand};
  const auto error = error_px(corners, from, to, plane_at(hand.thickness_m), free);
  if (!error) return Hindrance::moving;
  if (*error < kStill_px * scale_of(camera)) return std::nullopt;
  const double distance_m = to.T_camera_world.translation().norm();
  for (const double deeper : kDeeper) {
    const auto plane = plane_at(hand.thickness_m + deeper * distance_m);
    const auto there = error_px(corners, from, to, plane, free);
    if (there && *there < kBetter * *error) return Hindrance::off_ground;
  }
  return Hindrance::moving;
}

}  // namespace handyar::world
