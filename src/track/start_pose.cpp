// SPDX-License-Identifier: MIT
#include "track/start_pose.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "align/hand_view.hpp"
#include "pose/so3.hpp"

namespace handyar {
namespace {

constexpr double kFarthest_m = 5.0;

/// Places of a hand, in it and in the frame: fingertips and roots.
constexpr int kPlaces = 2 * kFingerCount;
struct Places {
  Eigen::Matrix<double, 3, kPlaces> hand_m;
  Eigen::Matrix<double, 2, kPlaces> px;

  Places(const RoughFingers& seen, const PosedFigure& hand) {
    for (int f = 0; f < kFingerCount; ++f) {
      hand_m.col(f) = hand.tips_m.col(f);
      hand_m.col(kFingerCount + f) = hand.centres_m.col(sphere_of(f, 0));
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
  const double angle = std::atan2(s, c),
               depth_m = std::clamp(size / std::hypot(c, s), kNearest_m, kFarthest_m);
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

Eigen::Isometry3d start_pose(const RoughFingers& seen, const PosedFigure& hand,
                             const Camera& camera, double tilt_sigma_rad) noexcept {
  const Places places(seen, hand);
  const Eigen::Isometry3d start = facing(places, camera);
  Eigen::Isometry3d T = start;
  const Eigen::Vector3d sight = T.translation().normalized();
  // Turning about the line of sight is free, tilting has the prior.
  const Eigen::Matrix3d tilt_information =
      (Eigen::Matrix3d::Identity() - sight * sight.transpose()) / (tilt_sigma_rad * tilt_sigma_rad);
  constexpr int kIterations = 6;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Matrix6d H = 1e-9 * Matrix6d::Identity();
    Vector6d g = Vector6d::Zero();
    for (int i = 0; i < kPlaces; ++i) {
      const Eigen::Vector3d turned = T.linear() * places.hand_m.col(i),
                            p = turned + T.translation();
      if (p.z() < kNearest_m) return start;
      Eigen::Matrix<double, 2, 3> J_point;
      const Eigen::Vector2d error = places.px.col(i) - camera.project(p, &J_point);
      Eigen::Matrix<double, 2, 6> J;
      J << -J_point * so3::skew(turned), J_point;
      H += J.transpose() * J / (seen.sigma_px * seen.sigma_px);
      g += J.transpose() * error / (seen.sigma_px * seen.sigma_px);
    }
    const Eigen::Vector3d turned_so_far =
        so3::log(Eigen::Matrix3d(T.linear() * start.linear().transpose()));
    H.topLeftCorner<3, 3>() += tilt_information;
    g.head<3>() -= tilt_information * turned_so_far;
    const Vector6d step = H.ldlt().solve(g);
    if (!step.allFinite()) return start;
    T.linear() = so3::turned(step.head<3>(), T.linear());
    T.translation() += step.tail<3>();
  }
  return T.translation().z() > kNearest_m ? T : start;
}

void spread_as_seen(const RoughFingers& seen, Appearance appearance, const Camera& camera,
                    HandState& state) noexcept {
  using Abductions = Eigen::Matrix<double, kFingerCount, 1>;
  using Information = Eigen::Matrix<double, kFingerCount, kFingerCount>;
  const Eigen::Isometry3d& T = state.T_camera_hand;
  const Eigen::Vector3d normal(0, 0, appearance.layout == Layout::thumb_right ? -1 : 1);
  const Information prior = abduction_covariance_rad2().llt().solve(Information::Identity());
  Eigen::Map<Abductions> abduction_rad(state.posture.abduction_rad.data());
  constexpr int kIterations = 2;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const PosedFigure hand = posed_figure(appearance, state);
    Information H = prior;
    Abductions g = -prior * abduction_rad;
    for (int f = 0; f < kFingerCount; ++f) {
      const Eigen::Vector3d tip = hand.tips_m.col(f), root = hand.centres_m.col(sphere_of(f, 0)),
                            p = T * tip;
      if (p.z() < kNearest_m) return;
      Eigen::Matrix<double, 2, 3> J_point;
      const Eigen::Vector2d error = seen.tips_px[f] - camera.project(p, &J_point),
                            J = J_point * (T.linear() * normal.cross(tip - root));
      H(f, f) += J.squaredNorm() / (seen.sigma_px * seen.sigma_px);
      g[f] += J.dot(error) / (seen.sigma_px * seen.sigma_px);
    }
    const Abductions step = H.llt().solve(g);
    if (!step.allFinite()) return;
    abduction_rad += step;
  }
}

}  // namespace handyar
