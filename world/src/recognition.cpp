// SPDX-License-Identifier: MIT
#include "recognition.hpp"

#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>

#include "handyar/opencv/types.hpp"

namespace handyar::world {
namespace {

constexpr std::size_t kFewestMatches = 12;
constexpr int kFewestInliers = 10;
constexpr float kMostBits = 64;    // of 256, in which the same corner may look otherwise
constexpr float kOnlyOne = 0.85f;  // the next best must look that much less alike
constexpr std::size_t kKeyframes = 3;
constexpr int kHypotheses = 200;
constexpr double kReprojection_px = 4;  // see scale_of()
constexpr Belief kLikely{15, kShareOfRight};

/// Points of the map that a keyframe shows, where corners of a picture look like them.
std::vector<Observation> alike(const Keyframe& keyframe, const Corners& corners) {
  std::vector<std::vector<cv::DMatch>> matches;
  cv::BFMatcher(cv::NORM_HAMMING).knnMatch(corners.descriptors, keyframe.descriptors, matches, 2);
  std::vector<Observation> pairs;
  for (const auto& best : matches) {
    if (best.size() < 2 || best[0].distance > kMostBits) continue;
    if (best[0].distance > kOnlyOne * best[1].distance) continue;
    const int point = keyframe.corner_points[static_cast<std::size_t>(best[0].trainIdx)];
    if (point < 0) continue;
    const cv::Point2f& px = corners.keypoints[static_cast<std::size_t>(best[0].queryIdx)].pt;
    pairs.push_back({point, {px.x, px.y}});
  }
  return pairs;
}

/// The pose on which most of the pairs agree, by all of those.
std::optional<Resection> pose_of(const WorldMap& map, const std::vector<Observation>& pairs,
                                 const Camera& camera) {
  std::vector<cv::Point3f> world_m;
  std::vector<cv::Point2f> px;
  for (const Observation& o : pairs) {
    const Eigen::Vector3f p = map.points[static_cast<std::size_t>(o.point)].p_world_m.cast<float>();
    world_m.emplace_back(p.x(), p.y(), p.z());
    px.emplace_back(static_cast<float>(o.px.x()), static_cast<float>(o.px.y()));
  }
  cv::Vec3d rotation, translation;
  std::vector<int> inliers;
  const bool solved = cv::solvePnPRansac(world_m, px, camera_matrix(camera), camera.distortion,
                                         rotation, translation, false, kHypotheses,
                                         static_cast<float>(kReprojection_px * scale_of(camera)),
                                         0.99, inliers, cv::SOLVEPNP_AP3P);
  if (!solved || std::ssize(inliers) < kFewestInliers) return std::nullopt;
  std::vector<Observation> agreeing;
  for (const int i : inliers) agreeing.push_back(pairs[static_cast<std::size_t>(i)]);
  return resect(map, agreeing, camera, isometry(rotation, translation));
}

}  // namespace

std::optional<Seen> recognise(const WorldMap& map, const Picture& picture, const cv::Mat& free,
                              const Camera& camera) {
  const Corners corners = find_corners(picture.grey, free);
  if (corners.keypoints.size() < kFewestMatches) return std::nullopt;
  std::vector<std::vector<Observation>> candidates;
  for (const Keyframe& keyframe : map.keyframes)
    if (keyframe.descriptors.rows >= 2) candidates.push_back(alike(keyframe, corners));
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  if (candidates.size() > kKeyframes) candidates.resize(kKeyframes);

  std::optional<Resection> best;
  for (const std::vector<Observation>& pairs : candidates) {
    if (pairs.size() < kFewestMatches) break;
    auto pose = pose_of(map, pairs, camera);
    if (pose && (!best || pose->inliers.size() > best->inliers.size())) best = std::move(pose);
  }
  if (!best) return std::nullopt;
  return look_twice(map, picture, free, {camera, best->T_camera_world}, kLikely);
}

}  // namespace handyar::world
