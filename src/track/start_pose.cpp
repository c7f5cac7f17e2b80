// SPDX-License-Identifier: MIT
#include "track/start_pose.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "align/hand_view.hpp"
#include "pose/so3.hpp"

namespace handyar {
namespace {

// The pose and the thumb's abduction.
constexpr int kThumb = 0, kThumbAt = 6, kUnknowns = 7;
using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;
using Information = Eigen::Matrix<double, kUnknowns, kUnknowns>;

constexpr double kFarthest_m = 5.0;

/// Places of a hand, in it and in the frame: fingertips and roots.
constexpr int kPlaces = 2 * kFingerCount;
struct Places {
  Eigen::Matrix<double, 3, kPlaces> hand_m;
  Eigen::Vector3d thumb_by_abduction_m;  ///< of its tip
  Eigen::Matrix<double, 2, kPlaces> px;

  Places(const RoughFingers& seen, const HandFigure& figure, const Posture& posture) {
    const PosedFigure hand = pose_fingers(figure, posture);
    for (int f = 0; f < kFingerCount; ++f) {
      hand_m.col(f) = hand.tips_m.col(f);
      hand_m.col(kFingerCount + f) = hand.centres_m.col(sphere_of(f, 0));
      px.col(f) = seen.tips_px[f];
      px.col(kFingerCount + f) = seen.roots_px[f];
    }
    thumb_by_abduction_m = hand.by_abduction_m.col(sphere_of(kThumb, kFingerSpheres - 1));
  }
};

/// Facing the camera: the similarity that lays the hand's places on the rays.
Eigen::Isometry3d facing(const Places& places, const Camera& camera) {
  Eigen::Matrix<double, 2, kPlaces> rays;
  for (int i = 0; i < kPlaces; ++i) rays.col(i) = camera.unproject(places.px.col(i).eval());
  const Eigen::Vector2d mean_ray = rays.rowwise().mean(),
                        mean_hand = places.hand_m.topRows<2>().rowwise().mean();
  // The camera's y points down, the hand's up: x to x, y to -y, turned by an angle.
  double c = 0, s = 0, size = 0;
  for (int i = 0; i < kPlaces; ++i) {
    const Eigen::Vector2d h = places.hand_m.col(i).head<2>() - mean_hand, a(h.x(), -h.y()),
                          b = rays.col(i) - mean_ray;
    c += a.dot(b);
    s += a.x() * b.y() - a.y() * b.x();
    size += a.squaredNorm();
  }
  const double scale = std::max(std::hypot(c, s) / size, 1 / kFarthest_m);
  const double angle = std::atan2(s, c), depth_m = std::clamp(1 / scale, kNearest_m, kFarthest_m);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix() *
               Eigen::Vector3d(1, -1, -1).asDiagonal();
  const Eigen::Vector3d line(mean_ray.x(), mean_ray.y(), 1);
  T.linear() = so3::between(Eigen::Vector3d::UnitZ(), line) * T.linear();
  const Eigen::Vector3d middle(mean_hand.x(), mean_hand.y(), 0);
  T.translation() = depth_m * line - T.linear() * middle;
  return T;
}

}  // namespace

HandState start_state(const RoughFingers& seen, const HandFigure& figure, const Posture& expected,
                      const Camera& camera, const MotionConfig& motion) noexcept {
  HandState start;
  start.posture = expected;
  start.T_camera_hand = facing(Places(seen, figure, expected), camera);
  HandState state = start;
  Eigen::Isometry3d& T = state.T_camera_hand;
  double& thumb_rad = state.posture.abduction_rad[kThumb];
  const Eigen::Vector3d sight = T.translation().normalized();
  // Turning about the line of sight is free, tilting has the prior.
  Information prior = 1e-9 * Information::Identity();
  prior.topLeftCorner<3, 3>() += (Eigen::Matrix3d::Identity() - sight * sight.transpose()) /
                                 (motion.rotation_sigma_rad * motion.rotation_sigma_rad);
  prior(kThumbAt, kThumbAt) = 1 / (motion.thumb_sigma_rad * motion.thumb_sigma_rad);
  constexpr int kIterations = 6;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const Places places(seen, figure, state.posture);
    Information H = prior;
    Unknowns off = Unknowns::Zero();
    off.head<3>() =
        so3::log(Eigen::Matrix3d(T.linear() * start.T_camera_hand.linear().transpose()));
    off[kThumbAt] = thumb_rad - expected.abduction_rad[kThumb];
    Unknowns g = -prior * off;
    for (int i = 0; i < kPlaces; ++i) {
      const Eigen::Vector3d turned = T.linear() * places.hand_m.col(i),
                            p = turned + T.translation();
      if (p.z() < kNearest_m) return start;
      Eigen::Matrix<double, 2, 3> J_point;
      const Eigen::Vector2d error = places.px.col(i) - camera.project(p, &J_point);
      Eigen::Matrix<double, 2, kUnknowns> J = Eigen::Matrix<double, 2, kUnknowns>::Zero();
      J.leftCols<3>() = -J_point * so3::skew(turned);
      J.middleCols<3>(3) = J_point;
      if (i == kThumb) J.col(kThumbAt) = J_point * T.linear() * places.thumb_by_abduction_m;
      H += J.transpose() * J / (seen.sigma_px * seen.sigma_px);
      g += J.transpose() * error / (seen.sigma_px * seen.sigma_px);
    }
    const Unknowns step = H.ldlt().solve(g);
    if (!step.allFinite()) return start;
    T.linear() =
        (so3::exp(step.head<3>()) * Eigen::Quaterniond(T.linear())).normalized().toRotationMatrix();
    T.translation() += step.segment<3>(3);
    thumb_rad += step[kThumbAt];
  }
  return T.translation().z() > kNearest_m ? state : start;
}

Eigen::Isometry3d other_planar_solution(const Eigen::Isometry3d& T_camera_hand) noexcept {
  const Eigen::Vector3d sight = -T_camera_hand.translation().normalized();
  const Eigen::Vector3d normal = T_camera_hand.linear().col(2);
  const Eigen::Vector3d mirrored = 2 * sight.dot(normal) * sight - normal;
  Eigen::Isometry3d other = T_camera_hand;
  other.linear() = so3::between(normal, mirrored).toRotationMatrix() * T_camera_hand.linear();
  return other;
}

}  // namespace handyar
