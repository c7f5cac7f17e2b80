// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <span>

#include "handyar/api.h"

namespace handyar {

/// A pose of a plane z = 0 and how well it fits.
struct PlanarPose {
  Eigen::Isometry3d T_camera_plane = Eigen::Isometry3d::Identity();
  double rms = 0.0;  ///< reprojection error per point, in normalised image coordinates
};

/// Both poses in which a plane looks (nearly) the same, the better one first: T. Collins and
/// A. Bartoli, "Infinitesimal Plane-based Pose Estimation", IJCV 2014. `plane_m` are points of the
/// plane, `normalised` their images at depth 1, distortion removed; at least four of each, in the
/// same order. Empty when there are fewer, when either set lies on a line, when a value is not
/// finite, or when points come to lie behind the camera. Closed form; takes no memory.
[[nodiscard]] HANDYAR_API std::optional<std::array<PlanarPose, 2>> solve_planar(
    std::span<const Eigen::Vector2d> plane_m, std::span<const Eigen::Vector2d> normalised) noexcept;

}  // namespace handyar
