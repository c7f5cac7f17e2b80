// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <numbers>

#include "handyar/api.h"

namespace handyar {

/// A pinhole camera with Brown-Conrady distortion, in OpenCV's convention: x right, y down,
/// z forward; the centre of the top-left pixel is (0, 0).
struct HANDYAR_API Camera {
  int width_px = 640;
  int height_px = 480;
  double fx_px = 554.256;
  double fy_px = 554.256;
  double cx_px = 319.5;
  double cy_px = 239.5;
  std::array<double, 5> distortion{};  ///< k1, k2, p1, p2, k3
  /// Rolling shutter: from the time of the first row to that of the last; 0: all at once. Poses are
  /// those at the time of the middle row.
  double readout_s = 0;
  bool assumed = false;  ///< not calibrated: a field of view was taken for granted

  /// A camera without distortion that sees `fov_rad` across the longer side of the picture.
  [[nodiscard]] static Camera from_field_of_view(int width_px, int height_px,
                                                 double fov_rad = std::numbers::pi / 3.0);

  /// The same camera read out at another size of the same aspect; an assumed one: of any aspect.
  [[nodiscard]] Camera scaled_to(int width_px, int height_px) const;

  /// When a row is read, after the middle one.
  [[nodiscard]] double row_time_s(double y_px) const noexcept {
    return ((y_px + 0.5) / height_px - 0.5) * readout_s;
  }

  /// Pixel of a point in the camera frame (metres, z > 0). With `J_px_point`, its 2x3 Jacobian.
  [[nodiscard]] Eigen::Vector2d project(
      const Eigen::Vector3d& p_camera,
      Eigen::Matrix<double, 2, 3>* J_px_point = nullptr) const noexcept;

  /// Point at depth 1 on the ray through a pixel, distortion removed: (x/z, y/z).
  [[nodiscard]] Eigen::Vector2d unproject(const Eigen::Vector2d& px) const noexcept;
};

}  // namespace handyar
