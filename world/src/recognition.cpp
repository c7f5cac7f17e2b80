// SPDX-License-Identifier: MIT
#include "recognition.hpp"

#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>

#include "handyar/opencv/types.hpp"

namespace handyar::world {
namespace {

constexpr int kFewestMatches = 12, kFewestInliers = 10;
constexpr float kMostBits = 64;    // of 256, in which the same corner may look otherwise
constexpr float kOnlyOne = 0.85f;  // the next best must look that much less alike
constexpr std::size_t kKeyframes = 3;
constexpr float kReprojection_px = 4;

struct Pairs {
  std::vector<cv::Point3f> world_m;
  std::vector<cv::Point2f> px;
};

Pairs pairs_with(const WorldMap& map, const Keyframe& keyframe, const Corners& corners) {
  Pairs pairs;
  std::vector<std::vector<cv::DMatch>> matches;
  cv::BFMatcher(cv::NORM_HAMMING).knnMatch(corners.descriptors, keyframe.descriptors, matches, 2);
  for (const auto& best : matches) {
    if (best.size() < 2 || best[0].distance > kMostBits) continue;
    if (best[0].distance > kOnlyOne * best[1].distance) continue;
    const int point = keyframe.corner_points[static_cast<std::size_t>(best[0].trainIdx)];
    if (point < 0) continue;
    const Eigen::Vector3f p = map.points[static_cast<std::size_t>(point)].p_world_m.cast<float>();
    pairs.world_m.emplace_back(p.x(), p.y(), p.z());
    pairs.px.push_back(corners.keypoints[static_cast<std::size_t>(best[0].queryIdx)].pt);
  }
  return pairs;
}

}  // namespace

std::optional<Eigen::Isometry3d> recognise(const WorldMap& map, const Picture& picture,
                                           const cv::Mat& free, const Camera& camera) {
  const Corners corners = find_corners(picture.grey, free);
  if (std::ssize(corners.keypoints) < kFewestMatches) return std::nullopt;
  std::vector<Pairs> candidates;
  for (const Keyframe& keyframe : map.keyframes)
    if (keyframe.descriptors.rows >= 2) candidates.push_back(pairs_with(map, keyframe, corners));
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Pairs& a, const Pairs& b) { return a.px.size() > b.px.size(); });
  if (candidates.size() > kKeyframes) candidates.resize(kKeyframes);

  std::optional<Eigen::Isometry3d> best;
  std::ptrdiff_t most = kFewestInliers - 1;
  for (const Pairs& pairs : candidates) {
    if (std::ssize(pairs.px) < kFewestMatches) break;
    cv::Vec3d rotation, translation;
    std::vector<int> inliers;
    const bool solved = cv::solvePnPRansac(
        pairs.world_m, pairs.px, camera_matrix(camera), camera.distortion, rotation, translation,
        false, 100, kReprojection_px * static_cast<float>(camera.width_px) / 640, 0.99, inliers,
        cv::SOLVEPNP_AP3P);
    if (!solved || std::ssize(inliers) <= most) continue;
    most = std::ssize(inliers);
    best = isometry(rotation, translation);
  }
  return best;
}

}  // namespace handyar::world
