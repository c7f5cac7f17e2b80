// SPDX-License-Identifier: MIT
#include "handyar/calibration/hand_frame.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <complex>

namespace handyar {
namespace {

using Tips2 = Eigen::Matrix<double, 2, kFingerCount>;

// Similarity a -> b in complex numbers: minimises |s a - b| over s, both centred.
struct Similarity {
  std::complex<double> s;
  double residual = 0;
};
Similarity similarity(const Tips2& a, const Tips2& b) {
  const Tips2 a0 = a.colwise() - a.rowwise().mean(), b0 = b.colwise() - b.rowwise().mean();
  std::complex<double> sum = 0;
  for (int k = 0; k < kFingerCount; ++k)
    sum += std::conj(std::complex(a0(0, k), a0(1, k))) * std::complex(b0(0, k), b0(1, k));
  const double energy = a0.squaredNorm();
  return {sum / energy, b0.squaredNorm() - std::norm(sum) / energy};
}

// Of the plane nearest to the tips: heights over it mean the same on palm and back, mirrored.
Eigen::Vector3d tips_normal(const Eigen::Matrix<double, 3, kFingerCount>& tips_m,
                            const Eigen::Vector3d& towards) {
  const Eigen::Matrix<double, 3, kFingerCount> centred = tips_m.colwise() - tips_m.rowwise().mean();
  const Eigen::Matrix3d scatter = centred * centred.transpose();
  const Eigen::Vector3d n =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(0);
  return n.dot(towards) < 0 ? Eigen::Vector3d(-n) : n;
}

}  // namespace

AverageHandFit fit_average_hand(const Tips2& tips_m) {
  AverageHandFit best;
  double least = std::numeric_limits<double>::infinity();
  for (Layout layout : {Layout::thumb_right, Layout::thumb_left}) {
    const Tips2 average = average_adult_hand().for_layout(layout).tips_m.topRows<2>();
    const Similarity fit = similarity(average, tips_m);
    if (fit.residual >= least) continue;
    least = fit.residual;
    best = {layout, std::abs(fit.s), std::arg(fit.s)};
  }
  return best;
}

Eigen::Isometry3d hand_frame(const HandPoints& points, const Eigen::Vector3d& outwards) {
  constexpr int kThumb = 0, kMiddle = 2;
  const Eigen::Vector3d z = tips_normal(points.tips_m, outwards);
  const Eigen::Vector3d middle = points.tips_m.col(kMiddle);
  Eigen::Vector3d along;
  if (points.has_webs) {
    along = middle - (points.webs_m.col(kMiddle - 1) + points.webs_m.col(kMiddle)) / 2;
  } else {
    const Eigen::Vector3d u = z.unitOrthogonal(), v = z.cross(u);
    Tips2 in_plane;
    in_plane << u.transpose() * points.tips_m, v.transpose() * points.tips_m;
    const double turn = fit_average_hand(in_plane).turn_rad;
    along = -std::sin(turn) * u + std::cos(turn) * v;
  }
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  const Eigen::Vector3d y = (along - along.dot(z) * z).normalized();
  T.linear() << y.cross(z), y, z;
  const Eigen::Vector3d mean = points.tips_m.rowwise().mean();
  const Eigen::Matrix3d R = T.linear().transpose();
  T.translation() =
      T.linear() *
      Eigen::Vector3d((R * middle).x(), (R * points.tips_m.col(kThumb)).y(), (R * mean).z());
  return T;
}

HandModel hand_model(const HandPoints& points, const Eigen::Isometry3d& T_points_hand) {
  HandModel m;
  const Eigen::Isometry3d T_hand_points = T_points_hand.inverse();
  for (int k = 0; k < kFingerCount; ++k) m.tips_m.col(k) = T_hand_points * points.tips_m.col(k);
  m.layout = m.tips_m(0, 0) > 0 ? Layout::thumb_right : Layout::thumb_left;
  return m;
}

}  // namespace handyar
