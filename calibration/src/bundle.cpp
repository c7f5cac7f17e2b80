// SPDX-License-Identifier: MIT
#include "bundle.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace handyar {
namespace {

constexpr double kIndependentViews = 10;  // outlines of neighbouring views err alike
constexpr double kLeastSigma_px = 0.3;
constexpr double kBehind = 1e6;  // cost of a pose with the hand behind the camera

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// Turn on the left in camera axes, then shift: the convention of PoseEstimate.
Eigen::Isometry3d moved(const Eigen::Isometry3d& T, const Eigen::Matrix<double, 6, 1>& d) {
  Eigen::Isometry3d out = T;
  const double angle = d.head<3>().norm();
  if (angle > 0)
    out.linear() = Eigen::AngleAxisd(angle, d.head<3>() / angle).toRotationMatrix() * T.linear();
  out.translation() += d.tail<3>();
  return out;
}

double spread_px(const Bundle& b, const Camera& camera) {
  std::vector<double> e;
  for (std::size_t k = 0; k < b.tracks.size(); ++k)
    for (std::size_t i = 0; i < b.T_camera_body.size(); ++i)
      if (b.tracks[k][i].allFinite())
        e.push_back((camera.project(b.T_camera_body[i] * b.p_m.col(k)) - b.tracks[k][i]).norm());
  std::nth_element(e.begin(), e.begin() + e.size() / 2, e.end());
  return std::max(e[e.size() / 2] / 1.18, kLeastSigma_px);
}

double prior_cost(const Bundle& b) {
  return ((b.p_m - b.prior_m).array() / b.prior_sigma_m.array()).square().sum() / 2;
}

double counts_as(const Bundle& b) {
  return std::min(1.0, kIndependentViews / static_cast<double>(b.T_camera_body.size()));
}

double cost(const Bundle& b, const Camera& camera) {
  double sum = 0;
  for (std::size_t i = 0; i < b.T_camera_body.size(); ++i)
    sum += b.view_cost(i, b.T_camera_body[i], camera);
  return counts_as(b) * sum + prior_cost(b);
}

struct NormalEquations {
  Eigen::MatrixXd H;  // poses first, six each, then points, three each
  Eigen::VectorXd g;
};

NormalEquations normal_equations(const Bundle& b, const Camera& camera) {
  const Eigen::Index views = static_cast<Eigen::Index>(b.T_camera_body.size());
  const Eigen::Index points = b.p_m.cols();
  NormalEquations n{Eigen::MatrixXd::Zero(6 * views + 3 * points, 6 * views + 3 * points),
                    Eigen::VectorXd::Zero(6 * views + 3 * points)};
  const double weight = counts_as(b) / (b.sigma_px * b.sigma_px);
  for (Eigen::Index k = 0; k < points; ++k) {
    const Eigen::Index at_point = 6 * views + 3 * k;
    for (Eigen::Index i = 0; i < views; ++i) {
      const Eigen::Vector2d& px = b.tracks[k][i];
      if (!px.allFinite()) continue;
      const Eigen::Isometry3d& T = b.T_camera_body[i];
      const Eigen::Vector3d turned = T.linear() * b.p_m.col(k);
      Eigen::Matrix<double, 2, 3> J;
      const Eigen::Vector2d r = px - camera.project(turned + T.translation(), &J);
      Eigen::Matrix<double, 2, 6> J_pose;
      J_pose << -J * skew(turned), J;
      const Eigen::Matrix<double, 2, 3> J_point = J * T.linear();
      const double w = weight / (1 + r.squaredNorm() / (b.sigma_px * b.sigma_px));  // Cauchy
      n.H.block<6, 6>(6 * i, 6 * i) += w * J_pose.transpose() * J_pose;
      n.H.block<3, 3>(at_point, at_point) += w * J_point.transpose() * J_point;
      n.H.block<3, 6>(at_point, 6 * i) += w * J_point.transpose() * J_pose;
      n.g.segment<6>(6 * i) += w * J_pose.transpose() * r;
      n.g.segment<3>(at_point) += w * J_point.transpose() * r;
    }
    const Eigen::Array3d information = b.prior_sigma_m.col(k).array().square().inverse();
    n.H.block<3, 3>(at_point, at_point).diagonal().array() += information;
    n.g.segment<3>(at_point).array() += information * (b.prior_m - b.p_m).col(k).array();
  }
  n.H.triangularView<Eigen::StrictlyUpper>() = n.H.transpose();
  return n;
}

}  // namespace

double Bundle::view_cost(std::size_t i, const Eigen::Isometry3d& T, const Camera& camera) const {
  double sum = 0;
  for (std::size_t k = 0; k < tracks.size(); ++k) {
    if (!tracks[k][i].allFinite()) continue;
    const Eigen::Vector3d p = T * p_m.col(k);
    if (p.z() <= 0) return kBehind;
    const double e2 = (camera.project(p) - tracks[k][i]).squaredNorm() / (sigma_px * sigma_px);
    sum += std::log1p(e2) / 2;
  }
  return sum;
}

void Bundle::adjust(const Camera& camera) {
  constexpr int kMaxSteps = 60;
  const Eigen::Index views = static_cast<Eigen::Index>(T_camera_body.size());
  double lambda = 1e-3;
  for (int s = 0; s < kMaxSteps && lambda < 1e8; ++s) {
    sigma_px = spread_px(*this, camera);
    const double before = cost(*this, camera);
    NormalEquations n = normal_equations(*this, camera);
    n.H.diagonal() *= 1 + lambda;
    const Eigen::VectorXd d = n.H.ldlt().solve(n.g);
    Bundle next = *this;
    for (Eigen::Index i = 0; i < views; ++i)
      next.T_camera_body[i] = moved(T_camera_body[i], d.segment<6>(6 * i));
    next.p_m += Eigen::Map<const Eigen::Matrix3Xd>(d.data() + 6 * views, 3, p_m.cols());
    const double after = cost(next, camera);
    if (!(after < before)) {
      lambda *= 10;
      continue;
    }
    *this = std::move(next);
    lambda = std::max(lambda / 5, 1e-9);
    if (before - after < 1e-7 * before) break;
  }
  const Eigen::Index all = 6 * views + 3 * p_m.cols();
  Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(all, 3 * p_m.cols());
  unit.bottomRows(3 * p_m.cols()).setIdentity();
  covariance_m2 = normal_equations(*this, camera).H.ldlt().solve(unit).bottomRows(3 * p_m.cols());
}

}  // namespace handyar
