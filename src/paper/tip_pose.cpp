// SPDX-License-Identifier: MIT
#include "handyar/paper/tip_pose.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "handyar/planar_pose.hpp"
#include "pose/so3.hpp"

namespace handyar::paper {
namespace {

struct Fit {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  Matrix6d information = Matrix6d::Zero();
  double squares = 0;  ///< of the reprojection errors, pixels
};

/// Gauss-Newton on the reprojection errors. False when a fingertip comes to lie behind the camera.
bool refine(const SeenTips& tips, const HandModel& hand, const Camera& camera, Fit& fit) {
  constexpr int kIterations = 12;
  constexpr double kNearest_m = 0.03, kDamping = 1e-6;
  for (int iteration = 0; iteration <= kIterations; ++iteration) {
    fit.information = kDamping * Matrix6d::Identity();
    fit.squares = 0;
    Vector6d g = Vector6d::Zero();
    for (int f = 0; f < kFingerCount; ++f) {
      if (!tips[f]) continue;
      const Eigen::Vector3d turned = fit.T.linear() * hand.tips_m.col(f);
      const Eigen::Vector3d p = turned + fit.T.translation();
      if (p.z() < kNearest_m) return false;
      Eigen::Matrix<double, 2, 3> J_point;
      const Eigen::Vector2d error = *tips[f] - camera.project(p, &J_point);
      Eigen::Matrix<double, 2, 6> J;
      J << -J_point * so3::skew(turned), J_point;
      fit.information += J.transpose() * J;
      fit.squares += error.squaredNorm();
      g += J.transpose() * error;
    }
    if (iteration == kIterations) break;
    const Vector6d step = fit.information.ldlt().solve(g);
    if (!step.allFinite()) return false;
    fit.T.linear() = (so3::exp(step.head<3>()) * Eigen::Quaterniond(fit.T.linear()))
                         .normalized()
                         .toRotationMatrix();
    fit.T.translation() += step.tail<3>();
  }
  return true;
}

/// The visible face looks at the camera.
bool faces_camera(const Eigen::Isometry3d& T) { return T.linear().col(2).dot(T.translation()) < 0; }

}  // namespace

std::optional<PoseEstimate> pose_from_tips(
    const SeenTips& tips, const HandModel& hand, const Camera& camera, double sigma_px,
    const std::optional<Eigen::Isometry3d>& expected) noexcept {
  std::array<Eigen::Vector2d, kFingerCount> plane_m, normalised;
  std::size_t count = 0;
  for (int f = 0; f < kFingerCount; ++f) {
    if (!tips[f] || !tips[f]->allFinite()) continue;
    plane_m[count] = hand.tips_m.col(f).head<2>();
    normalised[count++] = camera.unproject(*tips[f]);
  }
  if (count < 4) return std::nullopt;
  const auto planar = solve_planar({plane_m.data(), count}, {normalised.data(), count});
  if (!planar) return std::nullopt;

  // What one solution explains better than the other, in variances; a pose that goes on from the
  // last frame's is worth this much a radian.
  constexpr double kPerRadian = 20;
  std::optional<Fit> best;
  double best_cost = 0;
  for (const PlanarPose& start : *planar) {
    Fit fit;
    fit.T = start.T_camera_plane;
    if (!refine(tips, hand, camera, fit) || !faces_camera(fit.T)) continue;
    double cost = fit.squares / (sigma_px * sigma_px);
    if (expected)
      cost += kPerRadian *
              so3::log(Eigen::Matrix3d(fit.T.linear() * expected->linear().transpose())).norm();
    if (best && cost >= best_cost) continue;
    best = fit;
    best_cost = cost;
  }
  if (!best) return std::nullopt;
  PoseEstimate pose;
  pose.T_camera_hand = best->T;
  pose.rms_px = std::sqrt(best->squares / static_cast<double>(count));
  const double variance = std::max(sigma_px * sigma_px, pose.rms_px * pose.rms_px);
  pose.covariance = variance * best->information.llt().solve(Matrix6d::Identity());
  pose.noise_covariance = pose.covariance;
  return pose;
}

}  // namespace handyar::paper
