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
using Spreads = std::array<double, kFingerCount>;

constexpr int kMaxIterations = 20;
constexpr double kMinDepth_m = 0.01;
constexpr int kMaxFeatures = kMaxPosePoints + kFingerCount;

double huber_cost(double s2, double k) { return s2 <= k * k ? s2 : 2 * k * std::sqrt(s2) - k * k; }
double huber_weight(double s2, double k) { return s2 <= k * k ? 1.0 : k / std::sqrt(s2); }

/// 0 where the hand plane is seen from straight above, 1 where edge on.
double flatness(const Eigen::Isometry3d& T, const Eigen::Vector3d& hand_m) {
  return 1 - std::abs((T * hand_m).normalized().dot(T.linear().col(2)));
}

/// The point after its finger has turned.
PosePoint turned(const PosePoint& p, double spread_rad) {
  PosePoint t = p;
  t.hand_m += spread_rad * p.per_spread_m;
  return t;
}

/// The outline's point in the camera frame that is seen for a point of the hand.
Eigen::Vector3d seen_m(const PosePoint& p, const Eigen::Isometry3d& T) {
  const Eigen::Vector3d at = T * p.hand_m;
  if (p.radius_m == 0) return at;
  return outline_end_m(at, T.linear() * p.direction, p.radius_m, Eigen::Vector3d::Zero());
}

/// A point of a line about the hand's origin, in camera axes.
Eigen::Vector3d turned_m(const PoseLine& l, int point, double spread_rad,
                         const Eigen::Isometry3d& T) {
  return T.linear() * (l.hand_m[point] + spread_rad * l.per_spread_m[point]);
}

/// The image of a line: through one place, along the unit direction `along` (zero: it has none).
struct LineImage {
  Eigen::Vector2d from_px, along;
  double length_px;

  LineImage(const Eigen::Vector2d& a_px, const Eigen::Vector2d& b_px) : from_px(a_px) {
    constexpr double kShortest_px = 4;
    along = b_px - a_px;
    length_px = along.norm();
    if (length_px > kShortest_px)
      along /= length_px;
    else
      along.setZero();
  }
  Eigen::RowVector2d across() const { return {-along.y(), along.x()}; }
  double offset_px(const Eigen::Vector2d& px) const { return across().dot(px - from_px); }
};

/// Where the hand is, and how far each of its fingers has turned.
struct Posture {
  Eigen::Isometry3d T_camera_hand;
  Spreads spread_rad{};

  double spread_of(int finger) const { return finger < 0 ? 0 : spread_rad[finger]; }

  Posture moved(const Vector6d& step, const Spreads& turn) const {
    Posture next;
    next.T_camera_hand = Eigen::Isometry3d::Identity();
    const Eigen::Quaterniond q =
        so3::exp(step.head<3>()) * Eigen::Quaterniond(T_camera_hand.linear());
    next.T_camera_hand.linear() = q.normalized().matrix();
    next.T_camera_hand.translation() = T_camera_hand.translation() + step.tail<3>();
    for (int f = 0; f < kFingerCount; ++f) next.spread_rad[f] = spread_rad[f] + turn[f];
    return next;
  }
};

/// A point or a line at one posture: two residuals in pixels and what they depend on.
struct Residual {
  Eigen::Vector2d r;                ///< seen - projected
  Eigen::Matrix<double, 2, 6> J;    ///< of what is projected, by the pose
  Eigen::Vector2d j;                ///< and by the finger's spread
  Eigen::Matrix2d information;      ///< of r
  Eigen::Matrix<double, 6, 2> JtW;  ///< J' times the weighted information
  Eigen::RowVector2d jtW;
  double sigma_px;  ///< the part of r's deviation that is new in each frame
  int finger;       ///< -1: none
};

bool evaluate(const PosePoint& p, const Camera& camera, const Posture& at, Residual& out) {
  Eigen::Matrix<double, 2, 3> J_hand;
  if (!reprojection(turned(p, at.spread_of(p.finger)), camera, at.T_camera_hand, out.r, out.J,
                    J_hand))
    return false;
  const double flat = flatness(at.T_camera_hand, p.hand_m);
  Eigen::Matrix2d S = J_hand * (p.covariance_m2 + flat * flat * p.wander_m2) * J_hand.transpose();
  S.diagonal().array() += p.sigma_px * p.sigma_px;
  out.information = S.inverse();
  out.j = J_hand * p.per_spread_m;
  out.sigma_px = p.sigma_px;
  out.finger = p.finger;
  return true;
}

bool evaluate(const PoseLine& l, const Camera& camera, const Posture& at, Residual& out) {
  Eigen::Matrix2d S;
  if (!offset_of_line(l, camera, at.T_camera_hand, at.spread_of(l.finger), out.r, out.J, out.j, S))
    return false;
  out.information = S.inverse();
  out.sigma_px = l.sigma_px;
  out.finger = l.finger;
  return true;
}

/// The problem linearised at one posture. Each finger's spread is eliminated: H, g and the
/// residuals' JtW are what is left for the pose.
struct Linearised {
  Matrix6d H;  ///< J' W J
  Vector6d g;  ///< J' W r
  double cost = 0, chi2 = 0, points_chi2 = 0;
  struct Tips {
    double weight = 0, px2 = 0;  ///< by pixel noise; and with it their squared residuals
  };
  Tips tips, worst_tip;
  std::array<Residual, kMaxFeatures> residuals;
  int count = 0;

  struct Finger {
    double h = 0, g = 0;  ///< of the spread itself
    Vector6d with_pose = Vector6d::Zero();
  };
  std::array<Finger, kFingerCount> fingers;
  bool rigid = true;

  /// How the spreads change where the pose changes by `step`.
  Spreads turn(const Vector6d& step) const {
    Spreads turn{};
    for (int f = 0; f < kFingerCount && !rigid; ++f)
      turn[f] = (fingers[f].g - fingers[f].with_pose.dot(step)) / fingers[f].h;
    return turn;
  }
};

template <class Feature>
bool add(const Feature& feature, const Camera& camera, double huber, const Posture& at,
         Linearised& out) {
  Residual& e = out.residuals[out.count++];
  if (!evaluate(feature, camera, at, e)) return false;
  const double s2 = e.r.dot(e.information * e.r);
  const Eigen::Matrix2d W = huber_weight(s2, huber) * e.information;
  e.JtW.noalias() = e.J.transpose() * W;
  e.jtW.noalias() = e.j.transpose() * W;
  out.H.noalias() += e.JtW * e.J;
  out.g.noalias() += e.JtW * e.r;
  out.cost += huber_cost(s2, huber);
  out.chi2 += s2;
  if (e.finger >= 0 && !out.rigid) {
    Linearised::Finger& finger = out.fingers[e.finger];
    finger.h += e.jtW * e.j;
    finger.g += e.jtW * e.r;
    finger.with_pose += e.JtW * e.j;
  }
  return true;
}

bool linearise(const PoseFeatures& features, const Camera& camera, double huber, const Posture& at,
               Linearised& out) {
  out.H.setZero();
  out.g.setZero();
  out.cost = out.chi2 = 0;
  out.tips = out.worst_tip = {};
  out.count = 0;
  out.rigid = features.spread_sigma_rad == 0;
  const double prior = out.rigid ? 0 : 1 / (features.spread_sigma_rad * features.spread_sigma_rad);
  for (int f = 0; f < kFingerCount; ++f) {
    const double spread = at.spread_rad[f];
    out.fingers[f] = {prior, -prior * spread, Vector6d::Zero()};
    out.cost += prior * spread * spread;
    out.chi2 += prior * spread * spread;
  }
  for (const PosePoint& p : features.points()) {
    if (!add(p, camera, huber, at, out)) return false;
    if (p.finger < 0) continue;
    const Residual& tip = out.residuals[out.count - 1];
    const double weight = 1 / (p.sigma_px * p.sigma_px);
    const double px2 = weight * (tip.r + at.spread_of(p.finger) * tip.j).squaredNorm();
    out.tips = {out.tips.weight + weight, out.tips.px2 + px2};
    if (px2 > out.worst_tip.px2) out.worst_tip = {weight, px2};
  }
  out.points_chi2 = out.chi2;
  for (const PoseLine& l : features.lines())
    if (!add(l, camera, huber, at, out)) return false;
  if (out.rigid) return std::isfinite(out.cost);

  for (const Linearised::Finger& finger : out.fingers) {
    out.H.noalias() -= finger.with_pose * finger.with_pose.transpose() / finger.h;
    out.g -= finger.with_pose * (finger.g / finger.h);
  }
  for (int i = 0; i < out.count; ++i) {
    Residual& e = out.residuals[i];
    if (e.finger < 0) continue;
    const Linearised::Finger& finger = out.fingers[e.finger];
    e.JtW.noalias() -= finger.with_pose / finger.h * e.jtW;
  }
  return std::isfinite(out.cost);
}

/// Cost at another posture with the weights of this one; infinite behind the camera.
double cost_at(const PoseFeatures& features, const Camera& camera, double huber, const Posture& at,
               const Linearised& weights) {
  double cost = 0;
  if (!weights.rigid)
    for (const double spread : at.spread_rad)
      cost += spread * spread / (features.spread_sigma_rad * features.spread_sigma_rad);
  int i = 0;
  for (const PosePoint& p : features.points()) {
    const Eigen::Vector3d seen = seen_m(turned(p, at.spread_of(p.finger)), at.T_camera_hand);
    if (!(seen.z() > kMinDepth_m)) return std::numeric_limits<double>::infinity();
    const Eigen::Vector2d r = p.px - camera.project(seen);
    cost += huber_cost(r.dot(weights.residuals[i++].information * r), huber);
  }
  for (const PoseLine& l : features.lines()) {
    std::array<Eigen::Vector2d, 2> at_px;
    for (int k = 0; k < 2; ++k) {
      const Eigen::Vector3d p =
          turned_m(l, k, at.spread_of(l.finger), at.T_camera_hand) + at.T_camera_hand.translation();
      if (!(p.z() > kMinDepth_m)) return std::numeric_limits<double>::infinity();
      at_px[k] = camera.project(p);
    }
    const LineImage image(at_px[0], at_px[1]);
    const Eigen::Vector2d r(image.offset_px(l.px[0]), image.offset_px(l.px[1]));
    cost += huber_cost(r.dot(weights.residuals[i++].information * r), huber);
  }
  return cost;
}

/// The fit at a posture, with its covariance.
std::optional<FittedPose> fit_at(const PoseFeatures& features, const Camera& camera, double huber,
                                 const Posture& posture) {
  Linearised at;
  if (!linearise(features, camera, huber, posture, at)) return std::nullopt;
  const Eigen::LDLT<Matrix6d> ldlt(at.H);
  if (ldlt.info() != Eigen::Success || !(ldlt.vectorD().minCoeff() > 0)) return std::nullopt;
  FittedPose fit;
  fit.T_camera_hand = posture.T_camera_hand;
  fit.spread_rad = posture.spread_rad;
  fit.covariance = ldlt.solve(Matrix6d::Identity());
  fit.covariance = 0.5 * (fit.covariance + fit.covariance.transpose()).eval();
  if (!fit.covariance.allFinite()) return std::nullopt;
  Matrix6d noise = Matrix6d::Zero();  // covariance of g from pixel noise
  for (int i = 0; i < at.count; ++i) {
    const Residual& e = at.residuals[i];
    noise += e.sigma_px * e.sigma_px * e.JtW * e.JtW.transpose();
  }
  fit.noise_covariance = fit.covariance * noise * fit.covariance;
  fit.deviance = at.cost;
  fit.chi2 = at.chi2;
  fit.points_chi2 = at.points_chi2;
  // Among so many points one tip may be another's or none: it tells nothing of the fit.
  constexpr int kEnough = 7;
  if (features.point_count >= kEnough)
    at.tips = {at.tips.weight - at.worst_tip.weight, at.tips.px2 - at.worst_tip.px2};
  fit.rms_px = at.tips.weight > 0 ? std::sqrt(std::max(0.0, at.tips.px2 / at.tips.weight)) : 0;
  return fit;
}

}  // namespace

PoseFeatures PoseFeatures::mirrored() const {
  PoseFeatures m = *this;
  for (PosePoint& p : m.point) p.hand_m.z() = -p.hand_m.z();
  for (PoseLine& l : m.line)
    for (Eigen::Vector3d& p : l.hand_m) p.z() = -p.z();
  return m;
}

bool PoseFeatures::flat() const {
  return std::ranges::all_of(points(), [](const PosePoint& p) { return p.hand_m.z() == 0; }) &&
         std::ranges::all_of(lines(), [](const PoseLine& l) {
           return l.hand_m[0].z() == 0 && l.hand_m[1].z() == 0;
         });
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

bool offset_of_line(const PoseLine& line, const Camera& camera, const Eigen::Isometry3d& T,
                    double spread_rad, Eigen::Vector2d& residual_px,
                    Eigen::Matrix<double, 2, 6>& J_pose, Eigen::Vector2d& J_spread,
                    Eigen::Matrix2d& covariance_px2) {
  std::array<Eigen::Vector2d, 2> at_px;
  std::array<Eigen::Vector3d, 2> point_m;
  std::array<Eigen::Matrix<double, 2, 3>, 2> J_point;
  for (int k = 0; k < 2; ++k) {
    point_m[k] = turned_m(line, k, spread_rad, T);
    const Eigen::Vector3d at = point_m[k] + T.translation();
    if (!(at.z() > kMinDepth_m)) return false;
    at_px[k] = camera.project(at, &J_point[k]);
  }
  residual_px.setZero();
  J_pose.setZero();
  J_spread.setZero();
  covariance_px2 = line.sigma_px * line.sigma_px * Eigen::Matrix2d::Identity();
  const LineImage image(at_px[0], at_px[1]);
  if (image.along.isZero()) return true;
  const Eigen::RowVector2d across = image.across();

  // Where a place lies along the line tells how much each of its two points moves it.
  Eigen::Matrix2d share;
  for (int i = 0; i < 2; ++i) {
    const double s = image.along.dot(line.px[i] - image.from_px) / image.length_px;
    share.row(i) << 1 - s, s;
    residual_px[i] = image.offset_px(line.px[i]);
  }
  Eigen::Matrix2d variance = Eigen::Matrix2d::Zero();
  for (int k = 0; k < 2; ++k) {
    const Eigen::RowVector3d d = across * J_point[k];
    const Eigen::RowVector3d d_hand = d * T.linear();
    variance(k, k) = d_hand * line.covariance_m2 * d_hand.transpose();
    J_pose.leftCols<3>() -= share.col(k) * (d * so3::skew(point_m[k]));
    J_pose.rightCols<3>() += share.col(k) * d;
    J_spread += share.col(k) * d_hand.dot(line.per_spread_m[k]);
  }
  covariance_px2 += share * variance * share.transpose();
  return residual_px.allFinite();
}

std::optional<FittedPose> refine(const PoseFeatures& features, const Camera& camera, double huber,
                                 const Eigen::Isometry3d& start) {
  Posture posture{start, {}};
  Linearised at;
  double damping = 1e-4;
  for (int i = 0; i < kMaxIterations && damping < 1e6; ++i) {
    if (!linearise(features, camera, huber, posture, at)) return std::nullopt;
    Matrix6d damped = at.H;
    damped.diagonal() *= 1 + damping;
    const Eigen::LLT<Matrix6d> llt(damped);
    if (llt.info() != Eigen::Success) return std::nullopt;
    const Vector6d step = llt.solve(at.g);
    if (!step.allFinite()) return std::nullopt;
    const Posture next = posture.moved(step, at.turn(step));
    const double gain = at.g.dot(step);  // in squared standard deviations, to first order
    if (cost_at(features, camera, huber, next, at) > at.cost && gain > 1e-12) {
      damping *= 10;
      continue;
    }
    posture = next;
    damping = std::max(1e-9, damping * 0.1);
    if (gain < 1e-5) break;
  }
  return fit_at(features, camera, huber, posture);
}

}  // namespace handyar
