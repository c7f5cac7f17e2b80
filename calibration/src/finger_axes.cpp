// SPDX-License-Identifier: MIT
#include "finger_axes.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "handyar/calibration/camera_calibration.hpp"
#include "handyar/calibration/still_points.hpp"
#include "handyar/fingertips.hpp"

namespace handyar {
namespace {

constexpr double kHeightPrior_m = 0.010;  // of both points over the hand plane
constexpr double kLeastSigma_px = 0.1;

struct Sight {
  const Eigen::Isometry3d* T_camera_hand;
  const FingerAxis* axis;
};

// The line being sought: two points that move across the finger and up, and do not along it, where
// nothing tells them apart.
struct Line {
  Eigen::Vector3d end_m, root_m;
  Eigen::Vector3d across;
};

Line first_guess(const HandModel& hand, int finger) {
  const Eigen::Vector3d tip = hand.tips_m.col(finger), along = hand.directions().col(finger);
  double depth_m = std::numeric_limits<double>::infinity();
  for (const int k : {finger - 1, finger})
    if (k >= 0 && k < kValleyCount)
      depth_m = std::min(depth_m, (tip - hand.valleys_m.col(k)).dot(along));
  Line line{tip - kAxisEnd * depth_m * along, tip - kAxisRoot * depth_m * along,
            Eigen::Vector3d::UnitZ().cross(along)};
  line.end_m.z() = line.root_m.z() = 0;
  return line;
}

// How far both places that were seen lie beside the line's image, in pixels, and the derivatives by
// its four unknowns: across and up, of the end and of the root.
struct Offset {
  Eigen::Vector2d px;
  Eigen::Matrix<double, 2, 4> J;
};
std::optional<Offset> offset(const Line& line, const Sight& sight, const Camera& camera) {
  const Eigen::Isometry3d& T = *sight.T_camera_hand;
  const std::array points{Eigen::Vector3d(T * line.end_m), Eigen::Vector3d(T * line.root_m)};
  std::array<Eigen::Vector2d, 2> at_px;
  std::array<Eigen::Matrix<double, 2, 3>, 2> J;
  for (int k = 0; k < 2; ++k) {
    if (!(points[k].z() > 0)) return std::nullopt;
    at_px[k] = camera.project(points[k], &J[k]);
  }
  const Eigen::Vector2d along = at_px[1] - at_px[0];
  const double length2 = along.squaredNorm();
  if (!(length2 > 1)) return std::nullopt;
  const Eigen::RowVector2d across = Eigen::RowVector2d(-along.y(), along.x()) / std::sqrt(length2);
  Offset out;
  const std::array seen{sight.axis->end_px, sight.axis->root_px};
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector2d d = seen[i] - at_px[0];
    out.px[i] = across.dot(d);
    const double share = d.dot(along) / length2;
    for (int k = 0; k < 2; ++k) {
      const Eigen::RowVector3d per_m = (k == 0 ? 1 - share : share) * across * J[k] * T.linear();
      out.J.block<1, 2>(i, 2 * k) << per_m.dot(line.across), per_m.z();
    }
  }
  return out;
}

// One robust Gauss-Newton step; returns the largest move (metres).
double step(Line& line, const std::vector<Sight>& sights, const Camera& camera) {
  std::vector<Offset> offsets;
  std::vector<double> sizes_px;
  for (const Sight& s : sights) {
    const auto o = offset(line, s, camera);
    if (!o) continue;
    offsets.push_back(*o);
    for (const double px : o->px) sizes_px.push_back(std::abs(px));
  }
  if (offsets.empty()) return 0;
  const auto middle = sizes_px.begin() + static_cast<std::ptrdiff_t>(sizes_px.size() / 2);
  std::nth_element(sizes_px.begin(), middle, sizes_px.end());
  const double sigma_px = std::max(1.5 * *middle, kLeastSigma_px);  // of normal errors' median
  const double counts_as = std::min(1.0, kIndependentViews / static_cast<double>(offsets.size()));
  Eigen::Matrix4d H = Eigen::Matrix4d::Zero();
  Eigen::Vector4d g = Eigen::Vector4d::Zero();
  for (const Offset& o : offsets)
    for (int i = 0; i < 2; ++i) {
      const double w = counts_as / (sigma_px * sigma_px + o.px[i] * o.px[i]);  // Cauchy
      H += w * o.J.row(i).transpose() * o.J.row(i);
      g += w * o.J.row(i).transpose() * o.px[i];
    }
  const double prior = 1 / (kHeightPrior_m * kHeightPrior_m);
  H(1, 1) += prior;
  H(3, 3) += prior;
  g[1] -= prior * line.end_m.z();
  g[3] -= prior * line.root_m.z();
  const Eigen::Vector4d d = H.ldlt().solve(g);
  line.end_m += d[0] * line.across + d[1] * Eigen::Vector3d::UnitZ();
  line.root_m += d[2] * line.across + d[3] * Eigen::Vector3d::UnitZ();
  return d.lpNorm<Eigen::Infinity>();
}

}  // namespace

void triangulate_axes(std::span<const CalibrationView> views, const std::vector<int>& used,
                      std::span<const Eigen::Isometry3d> T_camera_hand, const Camera& camera,
                      HandModel& hand) {
  constexpr int kMaxSteps = 30;
  constexpr double kSmallMove_m = 1e-7, kFarthest_m = 0.03;
  if (!hand.has_valleys) return;
  for (int f = 0; f < kFingerCount; ++f) {
    std::vector<Sight> sights;
    for (std::size_t i = 0; i < used.size(); ++i)
      if (views[used[i]].axes[f].seen)
        sights.push_back({&T_camera_hand[i], &views[used[i]].axes[f]});
    if (static_cast<int>(sights.size()) < kMinViews) return;
    const Line guess = first_guess(hand, f);
    Line line = guess;
    for (int i = 0; i < kMaxSteps; ++i)
      if (step(line, sights, camera) < kSmallMove_m) break;
    const double moved_m =
        std::max((line.end_m - guess.end_m).norm(), (line.root_m - guess.root_m).norm());
    if (!(moved_m < kFarthest_m)) return;
    hand.axis_ends_m.col(f) = line.end_m;
    hand.axis_roots_m.col(f) = line.root_m;
  }
  hand.has_axes = true;
}

}  // namespace handyar
