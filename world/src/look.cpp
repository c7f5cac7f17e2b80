// SPDX-License-Identifier: MIT
#include "look.hpp"

#include <cmath>

#include "rigid.hpp"

namespace handyar::world {
namespace {

constexpr double kNear_px = 8, kFar_px = 12;  // see scale_of()

std::optional<Seen> look_within(double radius_px, const WorldMap& map, const Picture& picture,
                                const cv::Mat& free, const View& guess, const Belief& belief) {
  Seen seen;
  seen.reference = reference_for(map, guess);
  seen.matches = find_in_picture(map, map.keyframes[seen.reference], picture, free, guess,
                                 radius_px * scale_of(guess.camera), kMostPoints);
  seen.pose = resect(map, seen.matches.seen, guess.camera, guess.T_camera_world);
  const auto inliers = seen.pose.inliers.size();
  const double asked = belief.share * static_cast<double>(seen.matches.expected.size());
  if (inliers < belief.inliers || static_cast<double>(inliers) < asked) return std::nullopt;
  return seen;
}

}  // namespace

std::size_t reference_for(const WorldMap& map, const View& view) {
  std::vector<double> distances_m(map.points.size(), -1);  // of a point in view
  for (std::size_t i = 0; i < distances_m.size(); ++i)
    if (pixel_of(map.points[i].p_world_m, view))
      distances_m[i] = (view.T_camera_world * map.points[i].p_world_m).norm();
  std::size_t best = 0;
  double most = -1;
  for (std::size_t k = 0; k < map.keyframes.size(); ++k) {
    const Keyframe& keyframe = map.keyframes[k];
    double sum = 0;
    for (const Observation& o : keyframe.observations) {
      const double distance_m = distances_m[static_cast<std::size_t>(o.point)];
      if (distance_m < 0) continue;
      const Eigen::Vector3d& p = map.points[static_cast<std::size_t>(o.point)].p_world_m;
      const double angle = parallax_rad(view.T_camera_world, keyframe.T_camera_world, p);
      const double size = std::log(distance_m / (keyframe.T_camera_world * p).norm());
      sum += std::exp(-(angle * angle) / 0.1 - size * size / 0.2);
    }
    if (sum <= most) continue;
    most = sum;
    best = k;
  }
  return best;
}

std::optional<Seen> look(const WorldMap& map, const Picture& picture, const cv::Mat& free,
                         const View& guess, const Belief& belief) {
  return look_within(kNear_px, map, picture, free, guess, belief);
}

std::optional<Seen> look_twice(const WorldMap& map, const Picture& picture, const cv::Mat& free,
                               const View& guess, const Belief& belief) {
  constexpr Belief kSomething{12, 0.1};
  const auto roughly = look_within(kFar_px, map, picture, free, guess, kSomething);
  if (!roughly) return std::nullopt;
  return look(map, picture, free, {guess.camera, roughly->pose.T_camera_world}, belief);
}

}  // namespace handyar::world
