// SPDX-License-Identifier: MIT
#include "track/start_pose.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "align/hand_view.hpp"
#include "pose/so3.hpp"

namespace handyar {
namespace {

// Pose and the fingers' abductions.
constexpr int kUnknowns = 6 + kFingerCount;
using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;
using Information = Eigen::Matrix<double, kUnknowns, kUnknowns>;

constexpr double kFarthest_m = 5.0;

/// Places of a hand, in it and in the frame: fingertips and roots.
constexpr int kPlaces = 2 * kFingerCount;
struct Places {
  Eigen::Matrix<double, 3, kPlaces> hand_m;
  Eigen::Matrix<double, 3, kFingerCount> by_abduction_m;  ///< of the tips
  Eigen::Matrix<double, 2, kPlaces> px;

  Places(const RoughFingers& seen, const HandFigure& figure, const Posture& posture) {
    const PosedFigure hand = pose_fingers(figure, posture);
    for (int f = 0; f < kFingerCount; ++f) {
      hand_m.col(f) = hand.tips_m.col(f);
      hand_m.col(kFingerCount + f) = hand.centres_m.col(sphere_of(f, 0));
      by_abduction_m.col(f) = hand.by_abduction_m.col(sphere_of(f, kFingerSpheres - 1));
      px.col(f) = seen.tips_px[f];
      px.col(kFingerCount + f) = seen.roots_px[f];
    }
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
  const Eigen::Vector3d sight = T.translation().normalized();
  // Turning about the line of sight is free, tilting has the prior.
  Information prior = 1e-9 * Information::Identity();
  prior.topLeftCorner<3, 3>() += (Eigen::Matrix3d::Identity() - sight * sight.transpose()) /
                                 (motion.rotation_sigma_rad * motion.rotation_sigma_rad);
  for (int f = 0; f < kFingerCount; ++f) {
    const double sigma_rad = f == 0 ? motion.thumb_sigma_rad : motion.finger_sigma_rad;
    prior(6 + f, 6 + f) = 1 / (sigma_rad * sigma_rad);
  }
  constexpr int kIterations = 6;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const Places places(seen, figure, state.posture);
    Information H = prior;
    Unknowns off = Unknowns::Zero();
    off.head<3>() =
        so3::log(Eigen::Matrix3d(T.linear() * start.T_camera_hand.linear().transpose()));
    for (int f = 0; f < kFingerCount; ++f)
      off[6 + f] = state.posture.abduction_rad[f] - expected.abduction_rad[f];
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
      if (i < kFingerCount) J.col(6 + i) = J_point * T.linear() * places.by_abduction_m.col(i);
      H += J.transpose() * J / (seen.sigma_px * seen.sigma_px);
      g += J.transpose() * error / (seen.sigma_px * seen.sigma_px);
    }
    const Unknowns step = H.ldlt().solve(g);
    if (!step.allFinite()) return start;
    T.linear() =
        (so3::exp(step.head<3>()) * Eigen::Quaterniond(T.linear())).normalized().toRotationMatrix();
    T.translation() += step.segment<3>(3);
    for (int f = 0; f < kFingerCount; ++f) state.posture.abduction_rad[f] += step[6 + f];
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
