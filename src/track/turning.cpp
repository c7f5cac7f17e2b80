// SPDX-License-Identifier: MIT
#include "track/turning.hpp"

#include <algorithm>
#include <cmath>

#include "pose/so3.hpp"

namespace handyar {
namespace {

/// From the camera to the hand.
Eigen::Vector3d sight(const Eigen::Isometry3d& T_camera_hand) {
  return T_camera_hand.translation().normalized();
}

Eigen::Isometry3d with_normal(const Eigen::Isometry3d& T_camera_hand,
                              const Eigen::Vector3d& wanted) {
  Eigen::Isometry3d T = T_camera_hand;
  T.linear() = so3::between(T.linear().col(2), wanted).toRotationMatrix() * T.linear();
  return T;
}

/// A vector with its part across the line of sight turned round.
Eigen::Vector3d mirrored(const Eigen::Vector3d& v, const Eigen::Vector3d& sight) {
  return 2 * sight.dot(v) * sight - v;
}

}  // namespace

Eigen::Isometry3d other_planar_solution(const Eigen::Isometry3d& T_camera_hand) noexcept {
  return with_normal(T_camera_hand, mirrored(T_camera_hand.linear().col(2), sight(T_camera_hand)));
}

double turn_through_edge_rad(const Eigen::Isometry3d& T_camera_hand) noexcept {
  const double along = std::abs(sight(T_camera_hand).dot(T_camera_hand.linear().col(2)));
  return 2 * std::asin(std::min(along, 1.0));
}

HandState beyond_edge(const HandState& state) noexcept {
  HandState other = state;
  const Eigen::Isometry3d& T = state.T_camera_hand;
  other.T_camera_hand = with_normal(T, -mirrored(T.linear().col(2), sight(T)));
  other.velocity.head<3>() = mirrored(state.velocity.head<3>(), sight(T));
  return other;
}

bool turn_over(Appearance& appearance, Eigen::Isometry3d& T_camera_hand) noexcept {
  if (T_camera_hand.linear().col(2).dot(T_camera_hand.translation()) <= 0) return false;
  appearance = {opposite(appearance.face), opposite(appearance.layout)};
  T_camera_hand.linear().col(0) *= -1;
  T_camera_hand.linear().col(2) *= -1;
  return true;
}

}  // namespace handyar
