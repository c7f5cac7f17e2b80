// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>

namespace handyar::evaluation {

/// Rotation vector (rad) of a rotation matrix, its length in [0, pi].
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R);

/// Angle (rad) between two rotations.
double angle_between(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b);

/// The transform T with T * from closest to `to` in the least squares sense, points in columns.
Eigen::Isometry3d rigid_fit(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to);

/// Mean of transforms that all measure the same one, some of them badly: a translation and a
/// rotation, each weighted down (Cauchy) beyond its own median distance from the mean.
/// Precondition: at least one transform.
Eigen::Isometry3d robust_mean(std::span<const Eigen::Isometry3d> measurements);

}  // namespace handyar::evaluation
