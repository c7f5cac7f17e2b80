// SPDX-License-Identifier: MIT
#include "handyar/camera.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace handyar {
namespace {

/// Distorted normalised coordinates and their Jacobian (Brown-Conrady, as OpenCV defines it).
Eigen::Vector2d distort(const std::array<double, 5>& d, double x, double y, Eigen::Matrix2d* J) {
  const double k1 = d[0], k2 = d[1], p1 = d[2], p2 = d[3], k3 = d[4];
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  if (J != nullptr) {
    const double radial_r2 = k1 + r2 * (2 * k2 + 3 * r2 * k3);  // d radial / d r2
    const double xy = 2 * x * y * radial_r2 + 2 * p1 * x + 2 * p2 * y;
    *J << radial + 2 * x * x * radial_r2 + 2 * p1 * y + 6 * p2 * x, xy, xy,
        radial + 2 * y * y * radial_r2 + 6 * p1 * y + 2 * p2 * x;
  }
  return {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
          y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
}

}  // namespace

Camera Camera::from_field_of_view(int width_px, int height_px, double fov_rad) {
  Camera c;
  c.width_px = width_px;
  c.height_px = height_px;
  c.fx_px = c.fy_px = 0.5 * std::max(width_px, height_px) / std::tan(0.5 * fov_rad);
  c.cx_px = 0.5 * (width_px - 1);
  c.cy_px = 0.5 * (height_px - 1);
  c.assumed = true;
  return c;
}

Camera Camera::scaled_to(int new_width_px, int new_height_px) const {
  const double sx = static_cast<double>(new_width_px) / width_px;
  const double sy = static_cast<double>(new_height_px) / height_px;
  Camera c = *this;
  c.width_px = new_width_px;
  c.height_px = new_height_px;
  // What is assumed is the field of view across the longer side, of square pixels at any aspect.
  const double longer =
      static_cast<double>(std::max(new_width_px, new_height_px)) / std::max(width_px, height_px);
  c.fx_px *= assumed ? longer : sx;
  c.fy_px *= assumed ? longer : sy;
  c.cx_px = (cx_px + 0.5) * sx - 0.5;  // pixel centres are at whole numbers, edges at halves
  c.cy_px = (cy_px + 0.5) * sy - 0.5;
  return c;
}

Eigen::Vector2d Camera::project(const Eigen::Vector3d& p,
                                Eigen::Matrix<double, 2, 3>* J_px_point) const noexcept {
  const double inv_z = 1 / p.z(), x = p.x() * inv_z, y = p.y() * inv_z;
  Eigen::Matrix2d J_distort;
  const Eigen::Vector2d n = distort(distortion, x, y, J_px_point ? &J_distort : nullptr);
  if (J_px_point != nullptr) {
    Eigen::Matrix<double, 2, 3> J_normalised;
    J_normalised << inv_z, 0, -x * inv_z, 0, inv_z, -y * inv_z;
    *J_px_point = Eigen::Vector2d(fx_px, fy_px).asDiagonal() * J_distort * J_normalised;
  }
  return {fx_px * n.x() + cx_px, fy_px * n.y() + cy_px};
}

Eigen::Vector2d Camera::unproject(const Eigen::Vector2d& px) const noexcept {
  const Eigen::Vector2d distorted((px.x() - cx_px) / fx_px, (px.y() - cy_px) / fy_px);
  Eigen::Vector2d n = distorted;
  // Newton on the distortion: a few steps reach machine precision where the model is invertible.
  for (int i = 0; i < 8; ++i) {
    Eigen::Matrix2d J;
    const Eigen::Vector2d error = distort(distortion, n.x(), n.y(), &J) - distorted;
    const double det = J.determinant();
    if (error.squaredNorm() < 1e-24 || !(std::abs(det) > 1e-9)) break;
    n -= J.inverse() * error;
  }
  return n;
}

}  // namespace handyar
