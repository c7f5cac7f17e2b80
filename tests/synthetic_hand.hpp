// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "handyar/pose.hpp"

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

/// The left hand, back up, of the rendered sequences; valleys read off its mask, axes as
/// calibrated.
inline HandModel rendered_hand() {
  HandModel m;
  m.tips_m << 93.329, 42.131, 0.0, -35.356, -63.423,  //
      0.0, 73.632, 85.154, 72.671, 34.734,            //
      2.474, 0.202, -0.371, -0.703, -1.602;
  m.valleys_m << 35, 11.5, -13, -35,  //
      -17, 15, 15, 4,                 //
      1, 0, 0, -1;
  m.tips_m *= 1e-3;
  m.valleys_m *= 1e-3;
  m.axis_ends_m << 75.9, 37.8, 0.0, -33.7, -59.4,  //
      -3.0, 58.0, 68.7, 58.2, 26.5,                //
      2.3, -0.3, 0.7, 0.2, 1.4;
  m.axis_roots_m << 52.6, 27.6, 0.1, -24.8, -46.4,  //
      -22.4, 22.5, 28.2, 23.2, 5.0,                 //
      4.7, 4.4, 7.6, 8.9, 5.9;
  m.axis_ends_m *= 1e-3;
  m.axis_roots_m *= 1e-3;
  m.has_valleys = m.has_axes = true;
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

/// Exact images of the tips, and of valleys and axes if the model has them. Tips are the ends of
/// round fingers, or with a radius of 0 fixed points; webs are round.
inline HandObservation project(const HandModel& hand, const Camera& camera,
                               const Eigen::Isometry3d& T, double tip_radius_m = kTipRadius_m) {
  HandObservation o;
  const Eigen::Vector3d eye_m = T.inverse().translation();
  for (int i = 0; i < kFingerCount; ++i) {
    const Eigen::Vector3d end_m =
        outline_end_m(hand.tips_m.col(i), hand.directions().col(i), tip_radius_m, eye_m);
    o.tips[i] = {camera.project(T * end_m), 1.0, true};
  }
  for (int i = 0; i < kValleyCount && hand.has_valleys; ++i) {
    const Eigen::Vector3d end_m =
        outline_end_m(hand.valleys_m.col(i), hand.valley_directions().col(i), kWebRadius_m, eye_m);
    o.valleys[i] = {camera.project(T * end_m), 1.0, true};
  }
  for (int i = 0; i < kFingerCount && hand.has_axes; ++i)
    o.axes[i] = {camera.project(T * hand.axis_ends_m.col(i).eval()),
                 camera.project(T * hand.axis_roots_m.col(i).eval()), 1.0, true};
  return o;
}

inline void add_noise(HandObservation& o, double sigma_px, std::mt19937& rng) {
  const auto disturb = [&](ObservedPoint& p) {
    p.px += Eigen::Vector2d(gauss(rng, sigma_px), gauss(rng, sigma_px));
    p.sigma_px = sigma_px;
  };
  for (ObservedPoint& p : o.tips) disturb(p);
  for (ObservedPoint& p : o.valleys) disturb(p);
  for (ObservedAxis& a : o.axes) {
    if (!a.seen) continue;
    for (Eigen::Vector2d* const px : {&a.end_px, &a.root_px})
      *px += Eigen::Vector2d(gauss(rng, sigma_px), gauss(rng, sigma_px));
    a.sigma_px = sigma_px;
  }
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
