// SPDX-License-Identifier: MIT
#include "resection.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "picture.hpp"
#include "rigid.hpp"

namespace handyar::world {
namespace {

constexpr int kIterations = 10;
constexpr std::size_t kFewest = 6;
constexpr double kTukey = 4.685;  // of the usual error: farther ones do not count
constexpr double kLeastError_px = 0.4;
constexpr double kInlier_px = 2.5;  // see scale_of()
constexpr double kNear_m = 0.02;

using Matrix26d = Eigen::Matrix<double, 2, 6>;

struct Residual {
  Eigen::Vector2d error_px;
  Matrix26d J;
};

bool residual(const Eigen::Vector3d& p_camera, const Eigen::Vector2d& px, const Camera& camera,
              Residual& r) {
  if (p_camera.z() < kNear_m) return false;
  Eigen::Matrix<double, 2, 3> J_point;
  r.error_px = px - camera.project(p_camera, &J_point);
  r.J = J_point * jacobian_of_motion(p_camera);
  return true;
}

// What is usual among the errors: 1.48 times their median for normally distributed ones.
double usual_error_px(std::vector<double>& errors_px) {
  const auto middle = errors_px.begin() + static_cast<std::ptrdiff_t>(errors_px.size() / 2);
  std::nth_element(errors_px.begin(), middle, errors_px.end());
  return std::max(kLeastError_px, 1.48 * *middle);
}

}  // namespace

Resection resect(const WorldMap& map, std::span<const Observation> seen, const Camera& camera,
                 const Eigen::Isometry3d& T_camera_world) {
  Resection result;
  result.T_camera_world = T_camera_world;
  if (seen.size() < kFewest) return result;
  const auto point = [&](const Observation& o) {
    return result.T_camera_world * map.points[static_cast<std::size_t>(o.point)].p_world_m;
  };
  std::vector<double> errors_px;
  Matrix6d H;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    errors_px.clear();
    Residual r;
    for (const Observation& o : seen)
      if (residual(point(o), o.px, camera, r)) errors_px.push_back(r.error_px.norm());
    if (errors_px.size() < kFewest) return result;
    const double limit_px = kTukey * usual_error_px(errors_px);
    H.setZero();
    Eigen::Matrix<double, 6, 1> b = Eigen::Matrix<double, 6, 1>::Zero();
    for (const Observation& o : seen) {
      if (!residual(point(o), o.px, camera, r)) continue;
      const double far = r.error_px.squaredNorm() / (limit_px * limit_px);
      if (far >= 1) continue;
      const double weight = (1 - far) * (1 - far);
      H.noalias() += weight * r.J.transpose() * r.J;
      b.noalias() += weight * r.J.transpose() * r.error_px;
    }
    const Eigen::LDLT<Matrix6d> solver(H);
    const Eigen::Matrix<double, 6, 1> step = solver.solve(b);
    if (solver.info() != Eigen::Success || !step.allFinite()) return result;
    result.T_camera_world = moved(step, result.T_camera_world);
    if (step.norm() < 1e-7) break;
  }
  const double inlier_px = kInlier_px * scale_of(camera);
  double squares = 0;
  for (const Observation& o : seen) {
    Residual r;
    if (!residual(point(o), o.px, camera, r) || r.error_px.norm() > inlier_px) continue;
    result.inliers.push_back(o);
    squares += r.error_px.squaredNorm();
  }
  if (result.inliers.empty()) return result;
  const double mean = squares / static_cast<double>(result.inliers.size());
  result.rms_px = std::sqrt(mean);
  // Per axis: half of the squared distance. The step is about the camera, as the covariance is
  // told: rotation first, and the translation with it.
  result.covariance = about_origin(H.inverse() * (0.5 * mean), result.T_camera_world.translation());
  return result;
}

}  // namespace handyar::world
