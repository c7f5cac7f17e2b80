// SPDX-License-Identifier: MIT
#include "mapping.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "bundle.hpp"
#include "matching.hpp"
#include "picture.hpp"
#include "resection.hpp"
#include "rigid.hpp"

namespace handyar::world {
namespace {

constexpr std::size_t kFewestPoints = 20;
constexpr double kHeightSigma_m = 0.004;  // of points that lie on the plane under the hand

constexpr std::size_t kNeighbours = 4;  // keyframes that a new one is compared with
constexpr std::size_t kAdjusted = 6;    // keyframes that are adjusted together
constexpr double kLeastParallax_rad = 0.03;
constexpr double kMostParallax_rad = 0.7;
constexpr double kSame_px = 3;   // two corners are one
constexpr double kApart_px = 7;  // a new point keeps so far from others
constexpr double kReprojection_px = 1.5;
constexpr double kOutlier_px = 4;

double squared(double x) { return x * x; }

void tell_corner_points(Keyframe& keyframe) {
  keyframe.corner_points.assign(keyframe.corners.size(), -1);
  for (std::size_t c = 0; c < keyframe.corners.size(); ++c) {
    const Eigen::Vector2d px(keyframe.corners[c].pt.x, keyframe.corners[c].pt.y);
    double nearest = squared(kSame_px);
    for (const Observation& o : keyframe.observations) {
      const double d = (o.px - px).squaredNorm();
      if (d >= nearest) continue;
      nearest = d;
      keyframe.corner_points[c] = o.point;
    }
  }
}

/// Keyframes that look at the same from near by, the nearest first; `view` itself is left out.
std::vector<int> nearest(const WorldMap& map, int view, std::size_t count) {
  const Eigen::Isometry3d& T = map.keyframes[static_cast<std::size_t>(view)].T_camera_world;
  const Eigen::Vector3d eye = T.inverse().translation(), ahead = T.linear().row(2);
  std::vector<std::pair<double, int>> others;
  for (int k = 0; k < std::ssize(map.keyframes); ++k) {
    if (k == view) continue;
    const Eigen::Isometry3d& other = map.keyframes[static_cast<std::size_t>(k)].T_camera_world;
    const double turn =
        std::acos(std::clamp(ahead.dot(other.linear().row(2).transpose()), -1.0, 1.0));
    const double way = (eye - other.inverse().translation()).norm();
    others.emplace_back(turn + way / std::max(0.1, map.ground.absDistance(eye)), k);
  }
  std::sort(others.begin(), others.end());
  if (others.size() > count) others.resize(count);
  std::vector<int> result;
  for (const auto& [far, k] : others) result.push_back(k);
  return result;
}

/// Takes out the points of which `gone` is true.
void remove_points(WorldMap& map, const std::vector<bool>& gone) {
  std::vector<int> now(map.points.size(), -1);
  std::vector<MapPoint> kept;
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    if (gone[i]) continue;
    now[i] = static_cast<int>(kept.size());
    kept.push_back(map.points[i]);
  }
  map.points = std::move(kept);
  for (Keyframe& keyframe : map.keyframes) {
    for (Observation& o : keyframe.observations) o.point = now[static_cast<std::size_t>(o.point)];
    std::erase_if(keyframe.observations, [](const Observation& o) { return o.point < 0; });
    for (int& point : keyframe.corner_points)
      if (point >= 0) point = now[static_cast<std::size_t>(point)];
  }
}

void remove_not_found(WorldMap& map, const NewView& view) {
  constexpr int kTries = 10;
  std::vector<bool> gone(map.points.size(), false);
  for (std::size_t i = 0; i < std::min(gone.size(), view.tried.size()); ++i)
    gone[i] = view.tried[i] >= kTries && 4 * view.found[i] < view.tried[i];
  remove_points(map, gone);
}

/// The point that two cameras see, by least squares in the pictures; empty when it does not fit.
std::optional<Eigen::Vector3d> triangulated(const Camera& camera, const Eigen::Isometry3d& T_a,
                                            const Eigen::Vector2d& a_px,
                                            const Eigen::Isometry3d& T_b,
                                            const Eigen::Vector2d& b_px) {
  const auto eye = [](const Eigen::Isometry3d& T) -> Eigen::Vector3d {
    return T.inverse().translation();
  };
  const auto ray = [&](const Eigen::Isometry3d& T, const Eigen::Vector2d& px) -> Eigen::Vector3d {
    return (T.linear().transpose() * camera.unproject(px).homogeneous()).normalized();
  };
  // Nearest to both rays, then two steps of Gauss-Newton.
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const auto& [T, px] : {std::pair(&T_a, &a_px), std::pair(&T_b, &b_px)}) {
    const Eigen::Vector3d d = ray(*T, *px);
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - d * d.transpose();
    A += across;
    b += across * eye(*T);
  }
  Eigen::Vector3d p = A.ldlt().solve(b);
  for (int iteration = 0; iteration < 3; ++iteration) {
    A.setZero();
    b.setZero();
    for (const auto& [T, px] : {std::pair(&T_a, &a_px), std::pair(&T_b, &b_px)}) {
      const Eigen::Vector3d p_camera = *T * p;
      if (p_camera.z() < 0.03) return std::nullopt;
      Eigen::Matrix<double, 2, 3> J;
      const Eigen::Vector2d error_px = *px - camera.project(p_camera, &J);
      J = (J * T->linear()).eval();
      A += J.transpose() * J;
      b += J.transpose() * error_px;
      if (iteration == 2 && error_px.norm() > kReprojection_px) return std::nullopt;
    }
    if (iteration < 2) p += A.ldlt().solve(b);
  }
  const double parallax = parallax_rad(T_a, T_b, p);
  if (!p.allFinite() || parallax < kLeastParallax_rad || parallax > kMostParallax_rad)
    return std::nullopt;
  return p;
}

/// Sees in the newest keyframe what its neighbours show.
void observe_points_of(const std::vector<int>& neighbours, const Picture& picture,
                       const cv::Mat& free, WorldMap& map) {
  constexpr double kRadius_px = 5;
  Keyframe& newest = map.keyframes.back();
  std::vector<bool> seen(map.points.size(), false);
  for (const Observation& o : newest.observations) seen[static_cast<std::size_t>(o.point)] = true;
  for (const int k : neighbours) {
    const Matches matches =
        find_in_picture(map, map.keyframes[static_cast<std::size_t>(k)], picture, free,
                        {map.camera, newest.T_camera_world}, kRadius_px, 1000);
    for (const Observation& o : matches.seen) {
      if (seen[static_cast<std::size_t>(o.point)]) continue;
      seen[static_cast<std::size_t>(o.point)] = true;
      newest.observations.push_back(o);
    }
  }
}

/// Corners of the newest keyframe that show no point yet become points where another keyframe shows
/// them from elsewhere.
void add_points(const std::vector<int>& neighbours, WorldMap& map) {
  Keyframe& newest = map.keyframes.back();
  std::vector<Eigen::Vector2d> px;
  std::vector<std::size_t> which;
  for (std::size_t c = 0; c < newest.corners.size(); ++c) {
    const Eigen::Vector2d at(newest.corners[c].pt.x, newest.corners[c].pt.y);
    const bool taken =
        newest.corner_points[c] >= 0 ||
        std::any_of(newest.observations.begin(), newest.observations.end(),
                    [&](const Observation& o) { return (o.px - at).norm() < kApart_px; });
    const bool near_other = std::any_of(px.begin(), px.end(), [&](const Eigen::Vector2d& other) {
      return (other - at).norm() < kApart_px;
    });
    if (taken || near_other) continue;
    px.push_back(at);
    which.push_back(c);
  }
  for (const int k : neighbours) {
    Keyframe& other = map.keyframes[static_cast<std::size_t>(k)];
    const std::vector<Eigen::Vector2d> found =
        find_pixels(map, newest, px, other, make_picture(other.grey));
    for (std::size_t i = 0; i < px.size(); ++i) {
      if (newest.corner_points[which[i]] >= 0 || !found[i].allFinite()) continue;
      const auto p =
          triangulated(map.camera, newest.T_camera_world, px[i], other.T_camera_world, found[i]);
      if (!p) continue;
      const int point = static_cast<int>(map.points.size());
      map.points.push_back({*p, 0});
      newest.observations.push_back({point, px[i]});
      newest.corner_points[which[i]] = point;
      other.observations.push_back({point, found[i]});
    }
  }
}

/// Rays that miss their points by far, and points that are then held by too little.
void remove_outliers(WorldMap& map) {
  std::vector<int> rays(map.points.size(), 0);
  for (Keyframe& keyframe : map.keyframes)
    std::erase_if(keyframe.observations, [&](const Observation& o) {
      const Eigen::Vector3d p =
          keyframe.T_camera_world * map.points[static_cast<std::size_t>(o.point)].p_world_m;
      const bool off = p.z() < 0.02 || (map.camera.project(p) - o.px).norm() > kOutlier_px;
      if (!off) ++rays[static_cast<std::size_t>(o.point)];
      return off;
    });
  std::vector<bool> gone(map.points.size());
  for (std::size_t i = 0; i < gone.size(); ++i)
    gone[i] = rays[i] < (map.points[i].plane_sigma_m > 0 ? 1 : 2);
  remove_points(map, gone);
}

/// The plane of the points near the one known so far, what stands on it or lies beside it left out.
void fit_ground(WorldMap& map) {
  double limit_m = 0.03;
  for (int iteration = 0; iteration < 4; ++iteration, limit_m = std::max(0.006, limit_m / 2)) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    std::vector<Eigen::Vector3d> near;
    for (const MapPoint& point : map.points)
      if (map.ground.absDistance(point.p_world_m) < limit_m && point.p_world_m.norm() < 1)
        near.push_back(point.p_world_m);
    if (near.size() < kFewestPoints) return;
    for (const Eigen::Vector3d& p : near) mean += p / static_cast<double>(near.size());
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (const Eigen::Vector3d& p : near) scatter += (p - mean) * (p - mean).transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(scatter);
    // Points along a line tell no plane.
    if (axes.eigenvalues()[1] < 1e-2 * axes.eigenvalues()[2]) return;
    Eigen::Vector3d normal = axes.eigenvectors().col(0);
    if (normal.dot(map.ground.normal()) < 0) normal = -normal;
    map.ground = Eigen::Hyperplane<double, 3>(normal, mean);
  }
}

}  // namespace

std::optional<WorldMap> first_map(const cv::Mat& grey, const cv::Mat& free, const Camera& camera,
                                  const HandInWorld& hand) {
  WorldMap map;
  map.camera = camera;
  map.scale_assumed = hand.scale_assumed;
  map.hand_thickness_m = hand.thickness_m;
  map.ground = {Eigen::Vector3d::UnitZ(), hand.thickness_m};
  Keyframe keyframe;
  keyframe.grey = grey.clone();
  keyframe.T_camera_world = *hand.T_camera_hand;
  keyframe.hand_in_view = true;
  Corners corners = find_corners(grey, free);
  keyframe.corners = std::move(corners.keypoints);
  keyframe.descriptors = corners.descriptors;
  for (const cv::KeyPoint& corner : keyframe.corners) {
    const Eigen::Vector2d px(corner.pt.x, corner.pt.y);
    const bool taken =
        std::any_of(keyframe.observations.begin(), keyframe.observations.end(),
                    [&](const Observation& o) { return (o.px - px).norm() < kApart_px; });
    const auto p = on_ground(px, {camera, keyframe.T_camera_world}, map.ground);
    if (taken || !p) continue;
    keyframe.observations.push_back({static_cast<int>(map.points.size()), px});
    map.points.push_back({*p, kHeightSigma_m});
  }
  if (map.points.size() < kFewestPoints) return std::nullopt;
  tell_corner_points(keyframe);
  map.keyframes.push_back(std::move(keyframe));
  return map;
}

WorldMap extended(WorldMap map, const NewView& view) {
  Keyframe keyframe;
  keyframe.grey = view.grey;
  keyframe.T_camera_world = view.T_camera_world;
  keyframe.hand_in_view = !view.free.empty();
  keyframe.observations = view.seen;
  Corners corners = find_corners(view.grey, view.free);
  keyframe.corners = std::move(corners.keypoints);
  keyframe.descriptors = corners.descriptors;
  map.keyframes.push_back(std::move(keyframe));
  remove_not_found(map, view);

  const int newest = static_cast<int>(map.keyframes.size()) - 1;
  const std::vector<int> neighbours = nearest(map, newest, kNeighbours);
  observe_points_of(neighbours, make_picture(view.grey), view.free, map);
  std::vector<int> together = nearest(map, newest, kAdjusted - 1);
  together.push_back(newest);
  adjust(map, together);
  tell_corner_points(map.keyframes.back());
  add_points(neighbours, map);
  adjust(map, together);
  remove_outliers(map);
  fit_ground(map);
  return map;
}

}  // namespace handyar::world
