// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "handyar/pose.hpp"

namespace handyar::world {

inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d S;
  S << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return S;
}

/// A small motion of what is before the camera, rotation (rad) about the camera, then translation
/// (m), all in camera axes.
using Motion = Eigen::Matrix<double, 6, 1>;

inline Eigen::Isometry3d moved(const Motion& motion, const Eigen::Isometry3d& T_camera_world) {
  const Eigen::Vector3d turn = motion.head<3>();
  const double angle = turn.norm();
  Eigen::Isometry3d step = Eigen::Isometry3d::Identity();
  if (angle > 0) step.linear() = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
  step.translation() = motion.tail<3>();
  Eigen::Isometry3d T = step * T_camera_world;
  T.linear() = Eigen::Quaterniond(T.linear()).normalized().toRotationMatrix();
  return T;
}

/// How a point in the camera frame moves with a Motion.
inline Eigen::Matrix<double, 3, 6> jacobian_of_motion(const Eigen::Vector3d& p_camera) {
  Eigen::Matrix<double, 3, 6> J;
  J << -cross_matrix(p_camera), Eigen::Matrix3d::Identity();
  return J;
}

/// The covariance of a Motion as that of a pose: the error of the rotation, and of where the
/// world's origin is.
inline Matrix6d about_origin(const Matrix6d& of_motion, const Eigen::Vector3d& origin_camera) {
  Matrix6d J = Matrix6d::Identity();
  J.bottomLeftCorner<3, 3>() = -cross_matrix(origin_camera);
  return J * of_motion * J.transpose();
}

/// The angle at a point between the rays from two cameras.
inline double parallax_rad(const Eigen::Isometry3d& T_a_world, const Eigen::Isometry3d& T_b_world,
                           const Eigen::Vector3d& p_world) {
  const Eigen::Vector3d a = T_a_world.linear().transpose() * (T_a_world * p_world);
  const Eigen::Vector3d b = T_b_world.linear().transpose() * (T_b_world * p_world);
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace handyar::world
