// SPDX-License-Identifier: MIT
#include "pose_refinement.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "so3.hpp"

namespace handyar {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;

constexpr int kMaxIterations = 20;
constexpr double kMinDepth_m = 0.01;

double huber_cost(double s2, double k) { return s2 <= k * k ? s2 : 2 * k * std::sqrt(s2) - k * k; }
double huber_weight(double s2, double k) { return s2 <= k * k ? 1.0 : k / std::sqrt(s2); }

/// 0 where the hand plane is seen from straight above, 1 where edge on.
double flatness(const Eigen::Isometry3d& T, const Eigen::Vector3d& hand_m) {
  return 1 - std::abs((T * hand_m).normalized().dot(T.linear().col(2)));
}

/// The outline's point in the camera frame that is seen for a point of the hand.
Eigen::Vector3d seen_m(const PosePoint& p, const Eigen::Isometry3d& T) {
  const Eigen::Vector3d at = T * p.hand_m;
  if (p.radius_m == 0) return at;
  return outline_end_m(at, T.linear() * p.direction, p.radius_m, Eigen::Vector3d::Zero());
}

/// The problem linearised at one pose.
struct Linearised {
  Matrix6d H = Matrix6d::Zero();  ///< J' W J
  Vector6d g = Vector6d::Zero();  ///< J' W r
  double cost = 0, chi2 = 0;
  double tips = 0, tips_px2 = 0;  ///< weights of fingertips by pixel noise; of them and residuals
  // Of each point:
  std::array<Eigen::Matrix2d, kMaxPosePoints> information;      ///< of the residual, per px^2
  std::array<Eigen::Matrix<double, 6, 2>, kMaxPosePoints> JtW;  ///< its share of J' W
};

bool linearise(const PosePoints& points, const Camera& camera, double huber,
               const Eigen::Isometry3d& T, Linearised& out) {
  out.H.setZero();
  out.g.setZero();
  out.cost = out.chi2 = out.tips = out.tips_px2 = 0;
  for (int i = 0; i < points.count; ++i) {
    const PosePoint& p = points.at[i];
    Eigen::Vector2d r;
    Eigen::Matrix<double, 2, 6> J;
    Eigen::Matrix<double, 2, 3> J_hand;
    if (!reprojection(p, camera, T, r, J, J_hand)) return false;
    const double flat = flatness(T, p.hand_m);
    Eigen::Matrix2d S = J_hand * (p.covariance_m2 + flat * flat * p.wander_m2) * J_hand.transpose();
    S.diagonal().array() += p.sigma_px * p.sigma_px;
    const Eigen::Matrix2d information = S.inverse();
    const double s2 = r.dot(information * r);
    Eigen::Matrix<double, 6, 2>& JtW = out.JtW[i];
    JtW.noalias() = J.transpose() * (huber_weight(s2, huber) * information);
    out.H.noalias() += JtW * J;
    out.g.noalias() += JtW * r;
    out.cost += huber_cost(s2, huber);
    out.chi2 += s2;
    if (p.finger >= 0) {
      const double weight = 1 / (p.sigma_px * p.sigma_px);
      out.tips_px2 += weight * r.squaredNorm();
      out.tips += weight;
    }
    out.information[i] = information;
  }
  return std::isfinite(out.cost);
}

/// Cost at another pose with the weights of this one; infinite behind the camera.
double cost_at(const PosePoints& points, const Camera& camera, double huber,
               const Eigen::Isometry3d& T, const Linearised& at) {
  double cost = 0;
  for (int i = 0; i < points.count; ++i) {
    const Eigen::Vector3d p = seen_m(points.at[i], T);
    if (!(p.z() > kMinDepth_m)) return std::numeric_limits<double>::infinity();
    const Eigen::Vector2d r = points.at[i].px - camera.project(p);
    cost += huber_cost(r.dot(at.information[i] * r), huber);
  }
  return cost;
}

Eigen::Isometry3d moved(const Eigen::Isometry3d& T, const Vector6d& step) {
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  const Eigen::Quaterniond q = so3::exp(step.head<3>()) * Eigen::Quaterniond(T.linear());
  result.linear() = q.normalized().matrix();
  result.translation() = T.translation() + step.tail<3>();
  return result;
}

/// The fit at a pose, with its covariance.
std::optional<FittedPose> fit_at(const PosePoints& points, const Camera& camera, double huber,
                                 const Eigen::Isometry3d& T) {
  Linearised at;
  if (!linearise(points, camera, huber, T, at)) return std::nullopt;
  const Eigen::LDLT<Matrix6d> ldlt(at.H);
  if (ldlt.info() != Eigen::Success || !(ldlt.vectorD().minCoeff() > 0)) return std::nullopt;
  FittedPose fit;
  fit.T_camera_hand = T;
  fit.covariance = ldlt.solve(Matrix6d::Identity());
  fit.covariance = 0.5 * (fit.covariance + fit.covariance.transpose()).eval();
  if (!fit.covariance.allFinite()) return std::nullopt;
  Matrix6d noise = Matrix6d::Zero();  // covariance of g from pixel noise
  for (int i = 0; i < points.count; ++i)
    noise += points.at[i].sigma_px * points.at[i].sigma_px * at.JtW[i] * at.JtW[i].transpose();
  fit.noise_covariance = fit.covariance * noise * fit.covariance;
  fit.deviance = at.cost;
  fit.chi2 = at.chi2;
  fit.rms_px = at.tips > 0 ? std::sqrt(at.tips_px2 / at.tips) : 0;
  return fit;
}

}  // namespace

PosePoints PosePoints::without(int index) const {
  PosePoints rest;
  for (int i = 0; i < count; ++i)
    if (i != index) rest.push_back(at[i]);
  return rest;
}

bool reprojection(const PosePoint& point, const Camera& camera, const Eigen::Isometry3d& T,
                  Eigen::Vector2d& residual_px, Eigen::Matrix<double, 2, 6>& J_pose,
                  Eigen::Matrix<double, 2, 3>& J_hand_m) {
  const Eigen::Vector3d seen = seen_m(point, T);
  if (!(seen.z() > kMinDepth_m)) return false;
  Eigen::Matrix<double, 2, 3> J_point;
  residual_px = point.px - camera.project(seen, &J_point);
  // A round end turns with the finger about the line of sight alone: its centre moves, the rim that
  // is seen stays where it is.
  const Eigen::Vector3d direction = T.linear() * point.direction;
  const Eigen::Vector3d centre =
      T.linear() * (point.hand_m - point.radius_m * point.direction);  // about the hand's origin
  J_pose.leftCols<3>() = -J_point * so3::skew(centre);
  J_pose.rightCols<3>() = J_point;
  if (point.radius_m > 0) {
    const Eigen::Vector3d rim = seen - (centre + T.translation());
    const Eigen::Vector3d ray = seen.normalized();
    const double length = (direction - direction.dot(ray) * ray).norm();
    const Eigen::Vector3d out = rim.normalized();
    J_pose.leftCols<3>() -= point.radius_m / std::max(length, kEndOn) *
                            (J_point - J_point * out * out.transpose()) * so3::skew(direction);
  }
  J_hand_m = J_point * T.linear();
  return residual_px.allFinite();
}

std::optional<FittedPose> refine(const PosePoints& points, const Camera& camera, double huber,
                                 const Eigen::Isometry3d& start) {
  Eigen::Isometry3d T = start;
  Linearised at;
  double damping = 1e-4;
  for (int i = 0; i < kMaxIterations && damping < 1e6; ++i) {
    if (!linearise(points, camera, huber, T, at)) return std::nullopt;
    Matrix6d damped = at.H;
    damped.diagonal() *= 1 + damping;
    const Eigen::LLT<Matrix6d> llt(damped);
    if (llt.info() != Eigen::Success) return std::nullopt;
    const Vector6d step = llt.solve(at.g);
    if (!step.allFinite()) return std::nullopt;
    const Eigen::Isometry3d next = moved(T, step);
    const double gain = at.g.dot(step);  // in squared standard deviations, to first order
    if (cost_at(points, camera, huber, next, at) > at.cost && gain > 1e-12) {
      damping *= 10;
      continue;
    }
    T = next;
    damping = std::max(1e-9, damping * 0.1);
    if (gain < 1e-5) break;
  }
  return fit_at(points, camera, huber, T);
}

double spread_rad(const PosePoint& point, const Camera& camera, const Eigen::Isometry3d& T) {
  Eigen::Vector2d r;
  Eigen::Matrix<double, 2, 6> J;
  Eigen::Matrix<double, 2, 3> J_hand;
  if (!reprojection(point, camera, T, r, J, J_hand)) return 0;
  Eigen::Matrix2d S = J_hand * point.covariance_m2 * J_hand.transpose();
  S.diagonal().array() += point.sigma_px * point.sigma_px;
  const Eigen::Vector2d j = J_hand * point.per_spread_m;
  return point.spread_sigma_rad * point.spread_sigma_rad * j.dot(S.inverse() * r);
}

}  // namespace handyar
