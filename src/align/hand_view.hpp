// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "handyar/camera.hpp"
#include "pose/so3.hpp"

namespace handyar {

/// Nothing nearer than this to the camera is seen.
inline constexpr double kNearest_m = 0.03;

/// The picture as a camera without distortion would see it that looks straight at the hand: there
/// spheres are discs, wherever in the frame and behind whatever lens the hand is. Its pixels have
/// the frame's scale; (0, 0) is where it looks.
class HandView {
 public:
  HandView(const Camera& camera, const Eigen::Vector3d& towards_m)
      : camera_(camera),
        R_view_camera_(so3::between(towards_m, Eigen::Vector3d::UnitZ()).toRotationMatrix()),
        f_px_(0.5 * (camera.fx_px + camera.fy_px)) {}

  const Eigen::Matrix3d& R_view_camera() const { return R_view_camera_; }
  double f_px() const { return f_px_; }

  /// Pixel of the frame.
  Eigen::Vector2f to_frame(const Eigen::Vector2f& view_px) const {
    const Eigen::Vector3d ray(view_px.x() / f_px_, view_px.y() / f_px_, 1);
    return camera_.project(R_view_camera_.transpose() * ray).cast<float>();
  }

  /// From a pixel of the frame.
  Eigen::Vector2f from_frame(const Eigen::Vector2d& px) const {
    const Eigen::Vector3d ray = R_view_camera_ * camera_.unproject(px).homogeneous();
    return (f_px_ * ray.hnormalized()).cast<float>();
  }

 private:
  const Camera& camera_;
  Eigen::Matrix3d R_view_camera_;
  double f_px_;
};

}  // namespace handyar
