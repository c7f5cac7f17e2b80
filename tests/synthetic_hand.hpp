// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "handyar/camera.hpp"
#include "handyar/hand_model.hpp"

namespace handyar::test {

inline double deg(double degrees) { return degrees * std::numbers::pi / 180; }

/// Random numbers that depend on the test's name alone.
inline std::mt19937 random_for(const std::string& name) {
  std::seed_seq seed(name.begin(), name.end());
  return std::mt19937(seed);
}

inline double gauss(std::mt19937& rng, double sigma) {
  return std::normal_distribution<double>(0, 1)(rng) * sigma;
}
inline Eigen::Vector3d gauss3(std::mt19937& rng, double sigma) {
  return {gauss(rng, sigma), gauss(rng, sigma), gauss(rng, sigma)};
}

/// Fingertips of the left hand, back up, of the rendered sequences.
inline HandModel rendered_hand() {
  HandModel m;
  m.tips_m << 93.329, 42.131, 0.0, -35.356, -63.423,  //
      0.0, 73.632, 85.154, 72.671, 34.734,            //
      2.474, 0.202, -0.371, -0.703, -1.602;
  m.tips_m *= 1e-3;
  return m;
}

inline Camera rendered_camera() {
  Camera c;
  c.fx_px = c.fy_px = 618;
  c.cx_px = 322.38;
  c.cy_px = 236.94;
  return c;
}

/// The hand `distance_m` before the camera, face on, then tilted about an axis in its plane.
inline Eigen::Isometry3d hand_at(double distance_m, double tilt_rad, double axis_rad,
                                 const Eigen::Vector2d& offset_m = {0, -0.03}) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  const Eigen::AngleAxisd face_on(std::numbers::pi, Eigen::Vector3d::UnitX());
  const Eigen::Vector3d axis(std::cos(axis_rad), std::sin(axis_rad), 0);
  T.linear() = (Eigen::AngleAxisd(tilt_rad, axis) * face_on).toRotationMatrix();
  const Eigen::Vector3d centre = T.linear() * Eigen::Vector3d(0.007, 0.05, 0);
  T.translation() = Eigen::Vector3d(offset_m.x(), offset_m.y() + 0.03, distance_m) - centre;
  return T;
}

/// Rotation vector (camera axes, rad) and translation (m) from estimate to truth.
inline Eigen::Matrix<double, 6, 1> pose_error(const Eigen::Isometry3d& truth,
                                              const Eigen::Isometry3d& estimate) {
  const Eigen::AngleAxisd w(Eigen::Matrix3d(truth.linear() * estimate.linear().transpose()));
  Eigen::Matrix<double, 6, 1> e;
  e << w.angle() * w.axis(), truth.translation() - estimate.translation();
  return e;
}
inline double rotation_error_rad(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return pose_error(a, b).head<3>().norm();
}
inline double translation_error_m(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return (a.translation() - b.translation()).norm();
}

}  // namespace handyar::test
