// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "handyar/camera.hpp"

namespace handyar {

/// Of distorted pictures nothing is shown from farther out: 71 degrees from the middle.
inline constexpr double kFarthest_r2 = 9;

/// The squared distance from the middle at depth 1, at most `most`, up to which the distortion
/// grows outwards. Past it the polynomial turns back and means nothing.
inline double unfolded_r2(const Camera& camera, double most = kFarthest_r2) {
  constexpr double kStep = 0.01;
  const double k1 = camera.distortion[0], k2 = camera.distortion[1], k3 = camera.distortion[4];
  for (double r2 = 0; r2 < most; r2 += kStep)
    if (1 + r2 * (3 * k1 + r2 * (5 * k2 + r2 * 7 * k3)) <= 0) return r2;
  return most;
}

/// The pixel in which a camera shows a point; none behind it, and none so far to the side that the
/// distortion has turned back: Camera::project then gives a pixel that belongs to another
/// direction.
inline std::optional<Eigen::Vector2d> shown_at(const Camera& camera,
                                               const Eigen::Vector3d& p_camera) {
  if (!(p_camera.z() > 0)) return std::nullopt;
  const auto& d = camera.distortion;
  if (d[0] != 0 || d[1] != 0 || d[4] != 0) {
    const double r2 = p_camera.hnormalized().squaredNorm();
    if (r2 > kFarthest_r2 || unfolded_r2(camera, r2) < r2) return std::nullopt;
  }
  return camera.project(p_camera);
}

}  // namespace handyar
