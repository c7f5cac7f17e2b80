// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace handyar::so3 {

/// [v]x, with [v]x a = v x a.
inline Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d S;
  S << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return S;
}

/// Rotation by |w| about w.
inline Eigen::Quaterniond exp(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  const double k = angle < 1e-6 ? 0.5 - angle * angle / 48 : std::sin(0.5 * angle) / angle;
  const Eigen::Vector3d v = k * w;
  return {std::cos(0.5 * angle), v.x(), v.y(), v.z()};
}

/// R turned by |w| about w.
inline Eigen::Matrix3d turned(const Eigen::Vector3d& w, const Eigen::Matrix3d& R) {
  return (exp(w) * Eigen::Quaterniond(R)).normalized().toRotationMatrix();
}

/// Rotation vector of least length, at most pi.
inline Eigen::Vector3d log(const Eigen::Quaterniond& q) {
  const double s = q.vec().norm(), c = std::abs(q.w());
  const double k = s < 1e-9 ? 2.0 : 2 * std::atan2(s, c) / s;
  return (q.w() < 0 ? -k : k) * q.vec();
}
inline Eigen::Vector3d log(const Eigen::Matrix3d& R) { return log(Eigen::Quaterniond(R)); }

/// The least rotation that turns the direction of `from` into that of `to`, neither of them 0; of
/// opposite directions, one of those by half a turn. Eigen's own takes the compiler seconds.
inline Eigen::Quaterniond between(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d a = from.normalized(), b = to.normalized();
  // Twice the cosine of half the angle, which the cross product loses near half a turn.
  const double twice_c = (a + b).norm();
  if (twice_c < 1e-8) {
    const Eigen::Vector3d axis = a.unitOrthogonal();
    return {0, axis.x(), axis.y(), axis.z()};
  }
  const Eigen::Vector3d v = a.cross(b) / twice_c;
  return Eigen::Quaterniond(0.5 * twice_c, v.x(), v.y(), v.z()).normalized();
}

}  // namespace handyar::so3
