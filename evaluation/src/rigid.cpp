// SPDX-License-Identifier: MIT
#include "handyar/evaluation/rigid.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace handyar::evaluation {
namespace {

double median_of(std::vector<double> v) {
  std::nth_element(v.begin(), v.begin() + std::ptrdiff_t(v.size() / 2), v.end());
  return v[v.size() / 2];
}

/// Weighted mean of three-vectors; the weight falls off beyond the median distance from `about`.
Eigen::Vector3d cauchy_mean(const std::vector<Eigen::Vector3d>& v, const Eigen::Vector3d& about) {
  std::vector<double> distance(v.size());
  for (std::size_t i = 0; i < v.size(); ++i) distance[i] = (v[i] - about).norm();
  const double scale = std::max(median_of(distance), 1e-12);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double weights = 0;
  for (std::size_t i = 0; i < v.size(); ++i) {
    const double w = 1 / (1 + std::pow(distance[i] / scale, 2));
    sum += w * v[i];
    weights += w;
  }
  return sum / weights;
}

Eigen::Vector3d componentwise_median(const std::vector<Eigen::Vector3d>& v) {
  Eigen::Vector3d m;
  std::vector<double> c(v.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < v.size(); ++i) c[i] = v[i][axis];
    m[axis] = median_of(c);
  }
  return m;
}

}  // namespace

Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd aa(R);
  return aa.angle() * aa.axis();
}

double angle_between(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return std::acos(std::clamp(((a.transpose() * b).trace() - 1) / 2, -1.0, 1.0));
}

Eigen::Isometry3d rigid_fit(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to) {
  return Eigen::Isometry3d(Eigen::umeyama(from, to, /*with_scaling=*/false));
}

Eigen::Isometry3d robust_mean(std::span<const Eigen::Isometry3d> measurements) {
  constexpr int kIterations = 20;
  std::vector<Eigen::Vector3d> t, w(measurements.size());
  for (const Eigen::Isometry3d& T : measurements) t.push_back(T.translation());
  Eigen::Vector3d translation = componentwise_median(t);
  for (int i = 0; i < kIterations; ++i) translation = cauchy_mean(t, translation);

  // The start must not be an outlier: of a few rotations the one nearest to all others.
  Eigen::Matrix3d R = measurements[0].linear();
  double best = std::numeric_limits<double>::infinity();
  const std::size_t step = std::max<std::size_t>(1, measurements.size() / 20);
  for (std::size_t i = 0; i < measurements.size(); i += step) {
    double sum = 0;
    for (const Eigen::Isometry3d& T : measurements)
      sum += angle_between(measurements[i].linear(), T.linear());
    if (sum < best) best = sum, R = measurements[i].linear();
  }
  for (int i = 0; i < kIterations; ++i) {
    for (std::size_t k = 0; k < w.size(); ++k)
      w[k] = rotation_vector(R.transpose() * measurements[k].linear());
    const Eigen::Vector3d step_rad = cauchy_mean(w, Eigen::Vector3d::Zero());
    if (step_rad.norm() > 0) R = R * Eigen::AngleAxisd(step_rad.norm(), step_rad.normalized());
  }
  Eigen::Isometry3d mean = Eigen::Isometry3d::Identity();
  mean.linear() = Eigen::Quaterniond(R).normalized().toRotationMatrix();
  mean.translation() = translation;
  return mean;
}

}  // namespace handyar::evaluation
