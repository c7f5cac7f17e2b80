// SPDX-License-Identifier: MIT
#include "handyar/pose_filter.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "pose/so3.hpp"

namespace handyar {
namespace {

using Vector12d = MotionState::Vector12d;
using Matrix12d = MotionState::Matrix12d;

// Accelerations of the levels, as shares of the greatest, each 16 times the one before. The first
// is the hand at rest, the second one that is meant to be. One lasts for kRemembered_s in the mean.
constexpr std::array<double, 4> kLevelShare{0, 1.0 / 256, 1.0 / 16, 1};

// So that a measurement without any doubt can be weighed, too: of 1 um and 1 urad, squared.
constexpr double kTiny = 1e-12;

/// Quantile of the chi2 distribution with six degrees of freedom.
double chi2_quantile_6(double probability) {
  double low = 0, high = 200;
  for (int i = 0; i < 60; ++i) {
    const double x = 0.5 * (low + high), h = 0.5 * x;
    (1 - std::exp(-h) * (1 + h + 0.5 * h * h) < probability ? low : high) = x;
  }
  return high;
}

Vector6d diagonal(double rotation, double translation) {
  Vector6d d;
  d << Eigen::Vector3d::Constant(rotation), Eigen::Vector3d::Constant(translation);
  return d;
}

/// The part of the covariance that is new in each frame; all of it where the parts are not known.
Matrix6d fresh_covariance(const PoseEstimate& m) {
  return m.noise_covariance.isZero(0) ? m.covariance : m.noise_covariance;
}

Matrix6d noise_of(const PoseEstimate& m) {
  Matrix6d R = fresh_covariance(m);
  R.diagonal().array() += kTiny;
  return R;
}

Vector6d innovation(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& translation_m,
                    const PoseEstimate& m) {
  Vector6d y;
  y << so3::log(Eigen::Quaterniond(m.T_camera_hand.linear()) * rotation.conjugate()),
      m.T_camera_hand.translation() - translation_m;
  return y;
}

}  // namespace

Vector12d MotionState::difference(const MotionState& other) const noexcept {
  Vector12d e;
  e << so3::log(other.rotation * rotation.conjugate()), other.translation_m - translation_m,
      other.angular_velocity_rad_s - angular_velocity_rad_s, other.velocity_m_s - velocity_m_s;
  return e;
}

void MotionState::correct(const Vector12d& error) noexcept {
  rotation = (so3::exp(error.head<3>()) * rotation).normalized();
  translation_m += error.segment<3>(3);
  angular_velocity_rad_s += error.segment<3>(6);
  velocity_m_s += error.tail<3>();
}

void MotionState::advance(double dt, double density_m, double density_rad) noexcept {
  const Eigen::Vector3d turn = angular_velocity_rad_s * dt;
  const Eigen::Quaterniond turned = so3::exp(turn);
  rotation = (turned * rotation).normalized();
  translation_m += velocity_m_s * dt;

  Eigen::Matrix<double, 6, 6> F_pose = Matrix6d::Identity(), F_velocity = Matrix6d::Identity() * dt;
  F_pose.topLeftCorner<3, 3>() = turned.matrix();
  F_velocity.topLeftCorner<3, 3>() += 0.5 * dt * so3::skew(turn);  // left Jacobian, first terms
  const Matrix6d A = covariance.topLeftCorner<6, 6>(), B = covariance.topRightCorner<6, 6>(),
                 D = covariance.bottomRightCorner<6, 6>();
  const Matrix6d FB = F_pose * B * F_velocity.transpose();
  covariance.topLeftCorner<6, 6>() = F_pose * A * F_pose.transpose() + FB + FB.transpose() +
                                     F_velocity * D * F_velocity.transpose();
  covariance.topRightCorner<6, 6>() = F_pose * B + F_velocity * D;

  const Vector6d density = diagonal(density_rad, density_m) * std::abs(dt);
  covariance.topLeftCorner<6, 6>().diagonal() += density * (dt * dt / 3);
  covariance.topRightCorner<6, 6>().diagonal() += density * (dt / 2);
  covariance.bottomRightCorner<6, 6>().diagonal() += density;
  covariance.bottomLeftCorner<6, 6>() = covariance.topRightCorner<6, 6>().transpose().eval();
}

void MotionState::rest() noexcept {
  angular_velocity_rad_s.setZero();
  velocity_m_s.setZero();
  covariance.rightCols<6>().setZero();
  covariance.bottomRows<6>().setZero();
}

PoseFilter::PoseFilter(const PoseFilterConfig& config) noexcept
    : config_(config), gate_(chi2_quantile_6(config.gate_probability)) {}

void PoseFilter::reset() noexcept { running_ = false; }

void PoseFilter::start(double time_s, const PoseEstimate& m) noexcept {
  MotionState state;
  state.rotation = Eigen::Quaterniond(m.T_camera_hand.linear());
  state.translation_m = m.T_camera_hand.translation();
  state.covariance.topLeftCorner<6, 6>() = noise_of(m);
  // What a hand that speeds up as hard as is expected reaches.
  state.covariance.bottomRightCorner<6, 6>().diagonal() =
      (kLongest_s * diagonal(config_.acceleration_rad_s2, config_.acceleration_m_s2)).cwiseAbs2();
  levels_.fill({state, 1.0 / kLevels});
  lasting_ = m.covariance - fresh_covariance(m);
  time_s_ = time_s;
  running_ = true;
}

/// What each level starts from: the states of all, weighted by how probable a change to it is.
void PoseFilter::mix(double dt_s) noexcept {
  const double change = (1 - std::exp(-dt_s / kRemembered_s)) / (kLevels - 1);
  const std::array<Level, kLevels> before = levels_;
  std::array<std::array<Vector12d, kLevels>, kLevels> apart;  // error of i against j
  for (int j = 0; j < kLevels; ++j)
    for (int i = 0; i < kLevels; ++i) apart[j][i] = before[j].state.difference(before[i].state);

  for (int j = 0; j < kLevels; ++j) {
    std::array<double, kLevels> weight;
    double sum = 0;
    for (int i = 0; i < kLevels; ++i) {
      weight[i] = before[i].probability * (i == j ? 1 - change * (kLevels - 1) : change);
      sum += weight[i];
    }
    Vector12d mean = Vector12d::Zero();
    for (int i = 0; i < kLevels; ++i) mean += weight[i] / sum * apart[j][i];
    Matrix12d& P = levels_[j].state.covariance;
    P.setZero();
    for (int i = 0; i < kLevels; ++i) {
      const Vector12d e = apart[j][i] - mean;
      P += weight[i] / sum * (before[i].state.covariance + e * e.transpose());
    }
    levels_[j].state.correct(mean);
    levels_[j].probability = sum;
  }
}

bool PoseFilter::update(double time_s, const PoseEstimate& m) noexcept {
  if (!std::isfinite(time_s) || !m.T_camera_hand.matrix().allFinite() ||
      !m.covariance.allFinite() || !m.noise_covariance.allFinite())
    return false;
  if (running_ && time_s <= time_s_) return false;
  if (!running_ || !config_.enabled || time_s - time_s_ > config_.max_coast_s) {
    start(time_s, m);
    return true;
  }

  const double dt_s = time_s - time_s_;
  mix(dt_s);
  const Matrix6d R = noise_of(m);
  // The square of an acceleration times how long it lasts is a spectral density.
  const double m2 = config_.acceleration_m_s2 * config_.acceleration_m_s2 * kLongest_s;
  const double rad2 = config_.acceleration_rad_s2 * config_.acceleration_rad_s2 * kLongest_s;

  std::array<Eigen::LLT<Matrix6d>, kLevels> S;
  std::array<Vector6d, kLevels> y;
  std::array<double, kLevels> log_likelihood;
  double least_distance2 = std::numeric_limits<double>::infinity();
  for (int j = 0; j < kLevels; ++j) {
    MotionState& state = levels_[j].state;
    const double share2 = kLevelShare[j] * kLevelShare[j];
    if (j == 0)
      state.rest();
    else
      state.advance(dt_s, share2 * m2, share2 * rad2);
    y[j] = innovation(state.rotation, state.translation_m, m);
    S[j].compute(state.covariance.topLeftCorner<6, 6>() + R);
    const double distance2 = y[j].dot(S[j].solve(y[j]));
    const double log_det = 2 * S[j].matrixLLT().diagonal().array().log().sum();
    log_likelihood[j] = -0.5 * (distance2 + log_det);
    least_distance2 = std::min(least_distance2, distance2);
  }
  if (!(least_distance2 < gate_)) {
    start(time_s, m);
    return true;
  }

  const double best = *std::ranges::max_element(log_likelihood);
  double sum = 0;
  for (int j = 0; j < kLevels; ++j) {
    MotionState& state = levels_[j].state;
    const Eigen::Matrix<double, 12, 6> PHt = state.covariance.leftCols<6>();
    const Eigen::Matrix<double, 12, 6> K = S[j].solve(PHt.transpose()).transpose();
    state.correct(K * y[j]);
    state.covariance -= K * PHt.transpose();
    state.covariance = 0.5 * (state.covariance + state.covariance.transpose()).eval();
    levels_[j].probability *= std::exp(log_likelihood[j] - best);
    sum += levels_[j].probability;
  }
  for (Level& level : levels_) level.probability = std::max(level.probability / sum, 1e-9);
  lasting_ = m.covariance - fresh_covariance(m);
  time_s_ = time_s;
  return true;
}

MotionState PoseFilter::combined() const noexcept {
  const Level& likely = *std::ranges::max_element(levels_, {}, &Level::probability);
  std::array<Vector12d, kLevels> e;
  Vector12d mean = Vector12d::Zero();
  for (int i = 0; i < kLevels; ++i) {
    e[i] = likely.state.difference(levels_[i].state);
    mean += levels_[i].probability * e[i];
  }
  MotionState state = likely.state;
  state.covariance.setZero();
  for (int i = 0; i < kLevels; ++i)
    state.covariance += levels_[i].probability *
                        (levels_[i].state.covariance + (e[i] - mean) * (e[i] - mean).transpose());
  state.correct(mean);
  return state;
}

std::optional<FilteredPose> PoseFilter::predict(double time_s) const noexcept {
  if (!running_ || !(time_s - time_s_ <= config_.max_coast_s)) return std::nullopt;
  MotionState state = combined();
  if (config_.enabled) {
    double share2 = 0;
    for (int j = 0; j < kLevels; ++j)
      share2 += levels_[j].probability * kLevelShare[j] * kLevelShare[j];
    share2 *= kLongest_s;
    state.advance(time_s - time_s_, share2 * config_.acceleration_m_s2 * config_.acceleration_m_s2,
                  share2 * config_.acceleration_rad_s2 * config_.acceleration_rad_s2);
  }
  FilteredPose pose;
  pose.time_s = time_s;
  pose.T_camera_hand.linear() = state.rotation.matrix();
  pose.T_camera_hand.translation() = state.translation_m;
  pose.velocity_m_s = state.velocity_m_s;
  pose.angular_velocity_rad_s = state.angular_velocity_rad_s;
  pose.covariance = state.covariance.topLeftCorner<6, 6>() + lasting_;
  return pose;
}

}  // namespace handyar
