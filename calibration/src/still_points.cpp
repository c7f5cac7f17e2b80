// SPDX-License-Identifier: MIT
#include "handyar/calibration/still_points.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "handyar/hand_model.hpp"

namespace handyar {
namespace {

constexpr double kHeightSpread_m = 0.002;  // of fingertips on a table about their mean
constexpr double kWander_m = 0.008;
constexpr double kLeastSigma_px = 0.3;
constexpr double kUsual = 2.0 / 3;

double quantile(std::vector<double> v, double q) {
  if (v.empty()) return 0;
  const auto k = static_cast<std::ptrdiff_t>(q * static_cast<double>(v.size() - 1) + 0.5);
  std::nth_element(v.begin(), v.begin() + k, v.end());
  return v[static_cast<std::size_t>(k)];
}

// An outline's point is not a fixed one of the hand: what is not modelled of it wanders with the
// angle between the view and the board's normal, by as much as the hand is foreshortened.
double wander_m(const Eigen::Isometry3d& T_camera_board, const Eigen::Vector3d& p_m) {
  const Eigen::Vector3d ray = (T_camera_board * p_m).normalized();
  return kWander_m * (1 - std::abs(ray.dot(T_camera_board.linear().col(2))));
}

// Errors of a point in all views: pixels, and metres at the point.
template <class Seen>
void errors(const PixelTrack& track, std::span<const Eigen::Isometry3d> poses, const Camera& camera,
            const Seen& seen, std::vector<double>& px, std::vector<double>& m) {
  for (std::size_t i = 0; i < track.size(); ++i) {
    if (!track[i].allFinite()) continue;
    const Eigen::Vector3d c = seen(poses[i]);
    const double e = (camera.project(c) - track[i]).norm();
    px.push_back(e);
    m.push_back(e * c.z() / camera.fx_px);
  }
}

void judge(StillPoints& points, std::span<const PixelTrack> tracks,
           std::span<const Eigen::Isometry3d> poses, const Camera& camera) {
  const int n = static_cast<int>(tracks.size());
  points.error_m.resize(n);
  std::vector<double> all_px;
  for (int k = 0; k < n; ++k) {
    std::vector<double> m;
    errors(
        tracks[k], poses, camera,
        [&](const auto& T) { return T * points.p_m.col(k); }, all_px, m);
    points.error_m[k] = quantile(m, kUsual);
  }
  std::sort(all_px.begin(), all_px.end());
  all_px.resize(all_px.size() * 9 / 10);
  double sum = 0;
  for (double e : all_px) sum += e * e;
  points.rms_px = all_px.empty() ? 0 : std::sqrt(sum / static_cast<double>(all_px.size()));
}

// One robust Gauss-Newton step of all points together; returns the largest move (metres).
double step(StillPoints& points, std::span<const PixelTrack> tracks,
            std::span<const Eigen::Isometry3d> poses, const Camera& camera) {
  const int n = static_cast<int>(tracks.size());
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(3 * n, 3 * n);
  Eigen::VectorXd g = Eigen::VectorXd::Zero(3 * n);
  for (int k = 0; k < n; ++k) {
    std::vector<double> px, m;
    const auto seen = [&](const auto& T) { return T * points.p_m.col(k); };
    errors(tracks[k], poses, camera, seen, px, m);
    // The median of the length of an error with two equal components is 1.18 of their sigma.
    const double sigma_px = std::max(quantile(px, 0.5) / 1.18, kLeastSigma_px);
    const double counts_as = std::min(1.0, kIndependentViews / static_cast<double>(px.size()));
    for (std::size_t i = 0; i < tracks[k].size(); ++i) {
      if (!tracks[k][i].allFinite()) continue;
      Eigen::Matrix<double, 2, 3> J_px_camera;
      const Eigen::Vector2d r = tracks[k][i] - camera.project(seen(poses[i]), &J_px_camera);
      const Eigen::Matrix<double, 2, 3> J = J_px_camera * poses[i].linear();
      const double wander_px = wander_m(poses[i], points.p_m.col(k)) * J_px_camera(0, 0);
      const double variance = sigma_px * sigma_px + wander_px * wander_px;
      const double w = counts_as / (variance + r.squaredNorm());  // Cauchy
      H.block<3, 3>(3 * k, 3 * k) += w * J.transpose() * J;
      g.segment<3>(3 * k) += w * J.transpose() * r;
    }
  }
  const double w = 1 / (kHeightSpread_m * kHeightSpread_m);
  const double mean_z = points.p_m.row(2).mean();
  for (int k = 0; k < n; ++k) {
    g[3 * k + 2] -= w * (points.p_m(2, k) - mean_z);
    for (int j = 0; j < n; ++j) H(3 * k + 2, 3 * j + 2) += w * ((j == k) - 1.0 / n);
  }
  const Eigen::LDLT<Eigen::MatrixXd> solver(H);
  const Eigen::VectorXd d = solver.solve(g);
  points.p_m += Eigen::Map<const Eigen::Matrix3Xd>(d.data(), 3, n);
  const Eigen::MatrixXd covariance = solver.solve(Eigen::MatrixXd::Identity(3 * n, 3 * n));
  points.covariance_m2.resize(n);
  for (int k = 0; k < n; ++k) points.covariance_m2[k] = covariance.block<3, 3>(3 * k, 3 * k);
  return d.lpNorm<Eigen::Infinity>();
}

}  // namespace

double usual_error_m(const PixelTrack& track, std::span<const Eigen::Isometry3d> T_camera_point,
                     const Camera& camera, const Eigen::Vector3d& p_m) {
  std::vector<double> px, m;
  errors(
      track, T_camera_point, camera, [&](const auto& T) { return T * p_m; }, px, m);
  return quantile(m, kUsual);
}

Eigen::Vector3d unproject_to_plane(const Eigen::Vector2d& px,
                                   const Eigen::Isometry3d& T_camera_board, const Camera& camera,
                                   double height_m) {
  const Eigen::Isometry3d T_board_camera = T_camera_board.inverse();
  const Eigen::Vector3d ray = T_board_camera.linear() * camera.unproject(px).homogeneous();
  const Eigen::Vector3d eye = T_board_camera.translation();
  return eye + (-height_m - eye.z()) / ray.z() * ray;  // the board's z points into it
}

StillPoints on_plane(std::span<const PixelTrack> tracks,
                     std::span<const Eigen::Isometry3d> T_camera_board, const Camera& camera,
                     double height_m) {
  const int n = static_cast<int>(tracks.size());
  StillPoints out{Eigen::Matrix3Xd::Zero(3, n), {}, {}, 0};
  for (int k = 0; k < n; ++k) {
    std::vector<double> x, y;
    for (std::size_t i = 0; i < tracks[k].size(); ++i) {
      if (!tracks[k][i].allFinite()) continue;
      const Eigen::Vector3d p =
          unproject_to_plane(tracks[k][i], T_camera_board[i], camera, height_m);
      x.push_back(p.x());
      y.push_back(p.y());
    }
    out.p_m.col(k) << quantile(x, 0.5), quantile(y, 0.5), -height_m;
  }
  judge(out, tracks, T_camera_board, camera);
  return out;
}

StillPoints triangulate(std::span<const PixelTrack> tracks,
                        std::span<const Eigen::Isometry3d> T_camera_board, const Camera& camera) {
  constexpr double kFirstHeight_m = 0.01, kSmallMove_m = 1e-7;
  constexpr int kMaxSteps = 50;
  StillPoints out = on_plane(tracks, T_camera_board, camera, kFirstHeight_m);
  for (int i = 0; i < kMaxSteps; ++i)
    if (step(out, tracks, T_camera_board, camera) < kSmallMove_m) break;
  judge(out, tracks, T_camera_board, camera);
  return out;
}

}  // namespace handyar
