// SPDX-License-Identifier: MIT
#include "handyar/pose_filter.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "synthetic_hand.hpp"

namespace handyar {
namespace {

using test::deg;
using test::hand_at;
using Path = std::function<Eigen::Isometry3d(double time_s)>;

const Eigen::Vector3d kDirection = Eigen::Vector3d(1, 0.5, 0.7).normalized();
const Eigen::Vector3d kAxis = Eigen::Vector3d(1, 2, 0.5).normalized();

Eigen::Isometry3d at_rest(double = 0) { return hand_at(0.45, deg(30), 1.0); }

/// Moves by `along_m` and turns by `by_rad` from rest.
Eigen::Isometry3d displaced(double along_m, double by_rad) {
  Eigen::Isometry3d T = at_rest();
  T.linear() = Eigen::AngleAxisd(by_rad, kAxis) * T.linear();
  T.translation() += along_m * kDirection;
  return T;
}

/// To and fro over 10 cm and 40 degrees.
Path swinging(double hz) {
  return [hz](double t) {
    const double s = std::sin(2 * std::numbers::pi * hz * t);
    return displaced(0.05 * s, deg(20) * s);
  };
}

PoseEstimate exact(const Eigen::Isometry3d& T, double sigma_rad, double sigma_m) {
  PoseEstimate m;
  m.T_camera_hand = T;
  m.covariance.diagonal() << Eigen::Vector3d::Constant(sigma_rad * sigma_rad),
      Eigen::Vector3d::Constant(sigma_m * sigma_m);
  m.noise_covariance = m.covariance;
  return m;
}

PoseEstimate measured(const Eigen::Isometry3d& T, double sigma_rad, double sigma_m,
                      std::mt19937& rng) {
  PoseEstimate m = exact(T, sigma_rad, sigma_m);
  const Eigen::Vector3d w = test::gauss3(rng, sigma_rad);
  m.T_camera_hand.linear() = Eigen::AngleAxisd(w.norm(), w.normalized()) * T.linear();
  m.T_camera_hand.translation() += test::gauss3(rng, sigma_m);
  return m;
}

struct Figures {
  double jitter_deg = 0, jitter_mm = 0;  ///< standard deviation per axis over windows of 2 s
  double rms_deg = 0, rms_mm = 0;        ///< against the truth, per axis
  double delay_turn_ms = 0, delay_move_ms = 0;
  double nees = 0;
  int begun_anew = 0;  ///< after the first frame: then velocities are exactly zero
};

/// Runs the filter for 20 s, noise of `noise` mm and degrees, and measures after the first two.
Figures run(const Path& path, double fps, double noise, std::mt19937& rng,
            const PoseFilterConfig& config = {}) {
  PoseFilter filter(config);
  Figures f;
  std::vector<Eigen::Matrix<double, 6, 1>> errors;
  double turn_num = 0, turn_den = 0, move_num = 0, move_den = 0;
  for (int i = 0; i < 20 * fps; ++i) {
    const double t = i / fps, h = 1e-4;
    EXPECT_TRUE(filter.update(t, measured(path(t), deg(noise), 1e-3 * noise, rng)));
    if (i > 0 && filter.predict(t)->velocity_m_s.isZero(0)) ++f.begun_anew;
    const auto pose = filter.predict(t);
    if (!pose || t < 2) continue;
    const auto e = test::pose_error(path(t), pose->T_camera_hand);
    const auto v = (test::pose_error(path(t + h), path(t - h)) / (2 * h)).eval();
    turn_num += e.head<3>().dot(v.head<3>());
    turn_den += v.head<3>().squaredNorm();
    move_num += e.tail<3>().dot(v.tail<3>());
    move_den += v.tail<3>().squaredNorm();
    f.nees += e.dot(pose->covariance.ldlt().solve(e));
    errors.push_back(e);
  }
  const std::size_t window = static_cast<std::size_t>(2 * fps);
  Eigen::Matrix<double, 6, 1> variance = variance.Zero(), square = square.Zero();
  std::size_t count = 0;
  for (std::size_t begin = 0; begin + window <= errors.size(); begin += window) {
    Eigen::Matrix<double, 6, 1> mean = mean.Zero();
    for (std::size_t i = 0; i < window; ++i) mean += errors[begin + i] / double(window);
    for (std::size_t i = 0; i < window; ++i, ++count) {
      variance += (errors[begin + i] - mean).cwiseAbs2();
      square += errors[begin + i].cwiseAbs2();
    }
  }
  const double to_deg = 180 / std::numbers::pi, n = 3.0 * static_cast<double>(count);
  f.jitter_deg = to_deg * std::sqrt(variance.head<3>().sum() / n);
  f.jitter_mm = 1e3 * std::sqrt(variance.tail<3>().sum() / n);
  f.rms_deg = to_deg * std::sqrt(square.head<3>().sum() / n);
  f.rms_mm = 1e3 * std::sqrt(square.tail<3>().sum() / n);
  f.delay_turn_ms = 1e3 * turn_num / std::max(turn_den, 1e-12);
  f.delay_move_ms = 1e3 * move_num / std::max(move_den, 1e-12);
  f.nees /= static_cast<double>(errors.size());
  return f;
}

TEST(PoseFilter, StandsStillWhenTheHandDoes) {
  auto rng = test::random_for("PoseFilter.StandsStillWhenTheHandDoes");
  const Figures little = run(at_rest, 30, 0.5, rng), much = run(at_rest, 30, 1.0, rng);
  EXPECT_LT(little.jitter_mm, 0.12);
  EXPECT_LT(little.jitter_deg, 0.09);
  EXPECT_LT(much.jitter_mm, 0.15);
  EXPECT_LT(much.jitter_deg, 0.11);
  EXPECT_LT(much.rms_mm, 0.4) << "no drift";
  EXPECT_LT(much.rms_deg, 0.3);
  EXPECT_EQ(little.begun_anew + much.begun_anew, 0);
}

// A hand that is held still moves by tenths of a millimetre; seen straight on, its tilt is noise.
TEST(PoseFilter, TremorHardlyMakesItFollowTheNoiseOfTheTilt) {
  auto rng = test::random_for("PoseFilter.TremorHardlyMakesItFollowTheNoiseOfTheTilt");
  const Path trembling = [](double t) {
    return displaced(5e-4 * std::sin(2 * std::numbers::pi * t), 0);
  };
  PoseFilter filter;
  double square_deg2 = 0, square_mm2 = 0;
  int n = 0;
  for (int i = 0; i < 600; ++i) {
    const double t = i / 30.0;
    filter.update(t, measured(trembling(t), deg(2), 1e-4, rng));
    if (t < 1) continue;
    const auto e = test::pose_error(trembling(t), filter.predict(t)->T_camera_hand);
    square_deg2 += e.head<3>().squaredNorm() * std::pow(180 / std::numbers::pi, 2) / 3;
    square_mm2 += e.tail<3>().squaredNorm() * 1e6 / 3;
    ++n;
  }
  EXPECT_LT(std::sqrt(square_deg2 / n), 0.6) << "of 2 degrees";
  EXPECT_LT(std::sqrt(square_mm2 / n), 0.1);
}

TEST(PoseFilter, DoesNotLagWhenTheHandMoves) {
  auto rng = test::random_for("PoseFilter.DoesNotLagWhenTheHandMoves");
  for (double hz : {0.5, 1.0})
    for (double noise : {0.5, 1.0}) {
      const Figures f = run(swinging(hz), 30, noise, rng);
      EXPECT_LT(std::abs(f.delay_move_ms), 15) << hz << ' ' << noise;
      EXPECT_LT(std::abs(f.delay_turn_ms), 15) << hz << ' ' << noise;
      EXPECT_LT(f.rms_mm, 1.1 * noise) << hz << ' ' << noise;
      EXPECT_LT(f.rms_deg, 1.1 * noise) << hz << ' ' << noise;
      EXPECT_EQ(f.begun_anew, 0);
    }
}

TEST(PoseFilter, BehavesAlikeAtAnyFrameRate) {
  auto rng = test::random_for("PoseFilter.BehavesAlikeAtAnyFrameRate");
  for (double fps : {15.0, 30.0, 60.0}) {
    const Figures still = run(at_rest, fps, 0.5, rng), moving = run(swinging(0.5), fps, 0.5, rng);
    EXPECT_NEAR(still.jitter_mm, 0.085, 0.045) << fps;
    EXPECT_NEAR(still.jitter_deg, 0.065, 0.035) << fps;
    EXPECT_LT(std::abs(moving.delay_move_ms), 15) << fps;
    EXPECT_LT(std::abs(moving.delay_turn_ms), 15) << fps;
  }
}

TEST(PoseFilter, ItsCovarianceTellsTheTruth) {
  auto rng = test::random_for("PoseFilter.ItsCovarianceTellsTheTruth");
  for (double hz : {0.5, 1.0}) {
    const double nees = run(swinging(hz), 30, 0.7, rng).nees;
    EXPECT_GT(nees, 4.0) << hz;
    EXPECT_LT(nees, 9.0) << hz;
  }
  const double at_rest_nees = run(at_rest, 30, 0.7, rng).nees;
  EXPECT_GT(at_rest_nees, 1.5);
  EXPECT_LT(at_rest_nees, 8.0);
}

TEST(PoseFilter, AnErrorThatStaysIsNotAveragedOut) {
  PoseFilter filter;
  PoseEstimate m = exact(at_rest(), deg(0.5), 0.0005);
  m.covariance *= 9;  // most of it is the model's
  for (int i = 0; i < 60; ++i) filter.update(i / 30.0, m);
  const auto pose = filter.predict(59 / 30.0);
  ASSERT_TRUE(pose);
  EXPECT_GT(sigma_translation_m(pose->covariance), std::sqrt(8.0) * 0.0005);
  EXPECT_LT(sigma_translation_m(pose->covariance), 3 * 0.0005);
}

TEST(PoseFilter, ConvergesOnConstantVelocityAndPredicts) {
  PoseFilter filter;
  const Path path = [](double t) { return displaced(0.2 * t, deg(60) * t); };
  for (int i = 0; i <= 30; ++i)
    EXPECT_TRUE(filter.update(i / 30.0, exact(path(i / 30.0), 1e-3, 1e-4)));
  for (double ahead_s : {0.0, 0.05, 0.1}) {
    const auto pose = filter.predict(1.0 + ahead_s);
    ASSERT_TRUE(pose);
    EXPECT_EQ(pose->time_s, 1.0 + ahead_s);
    EXPECT_LT(test::translation_error_m(pose->T_camera_hand, path(1.0 + ahead_s)), 0.001);
    EXPECT_LT(test::rotation_error_rad(pose->T_camera_hand, path(1.0 + ahead_s)), deg(0.5));
    EXPECT_LT((pose->velocity_m_s - 0.2 * kDirection).norm(), 0.01);
    EXPECT_LT((pose->angular_velocity_rad_s - deg(60) * kAxis).norm(), deg(5));
  }
  EXPECT_GT(filter.predict(1.1)->covariance.trace(), filter.predict(1.0)->covariance.trace());
  EXPECT_TRUE(filter.predict(1.24));
  EXPECT_FALSE(filter.predict(1.26)) << "longer than max_coast_s";
}

TEST(PoseFilter, TurnsSmoothlyThrough180Degrees) {
  PoseFilter filter;
  double worst_rad = 0, furthest_step_rad = 0;
  Eigen::Matrix3d last = Eigen::Matrix3d::Identity();
  for (int i = 0; i < 240; ++i) {
    const double t = i / 30.0;
    const Eigen::Isometry3d truth = displaced(0, deg(90) * t);  // two full turns
    filter.update(t, exact(truth, deg(0.5), 0.0005));
    const auto pose = filter.predict(t);
    ASSERT_TRUE(pose);
    if (i > 10) {
      worst_rad = std::max(worst_rad, test::rotation_error_rad(pose->T_camera_hand, truth));
      furthest_step_rad =
          std::max(furthest_step_rad,
                   Eigen::AngleAxisd(pose->T_camera_hand.linear() * last.transpose()).angle());
    }
    last = pose->T_camera_hand.linear();
  }
  EXPECT_LT(worst_rad, deg(0.5));
  EXPECT_LT(furthest_step_rad, deg(4.0));  // 3 degrees a frame
}

TEST(PoseFilter, StartsAnewWhereNoHandCouldHaveMovedTo) {
  auto rng = test::random_for("PoseFilter.StartsAnewWhereNoHandCouldHaveMovedTo");
  for (const int fps : {15, 30, 60, 120}) {
    PoseFilter filter;
    double t = 0;
    const auto next = [&](const Eigen::Isometry3d& T) {
      t += 1.0 / fps;
      EXPECT_TRUE(filter.update(t, measured(T, deg(0.7), 0.0007, rng)));
      return filter.predict(t)->T_camera_hand;
    };
    // Turning by 90 degrees a second, and then put straight: the turning does not go on.
    const auto turned = [&](double time_s) { return hand_at(0.45, deg(90) * time_s, 1.0); };
    while (t < 0.3) next(turned(t));
    const Eigen::Isometry3d straight = hand_at(0.45, deg(-30), 1.0);
    EXPECT_LT(test::rotation_error_rad(next(straight), straight), deg(3)) << fps;
    const double straight_s = t;
    while (t < straight_s + 0.2)
      EXPECT_LT(test::rotation_error_rad(next(straight), straight), deg(3)) << fps << ", " << t;
    const Eigen::Isometry3d elsewhere = displaced(0.4, deg(120));
    EXPECT_LT(test::rotation_error_rad(next(elsewhere), elsewhere), deg(3)) << fps;
  }
}

TEST(PoseFilter, ForgetsOnResetAndAfterALongGap) {
  PoseFilter filter;
  EXPECT_FALSE(filter.predict(0));
  EXPECT_TRUE(filter.update(5.0, exact(at_rest(), 0.01, 0.001)));
  EXPECT_TRUE(filter.predict(5.0));
  filter.reset();
  EXPECT_FALSE(filter.predict(5.0));
  EXPECT_TRUE(filter.update(1.0, exact(at_rest(), 0.01, 0.001))) << "an earlier time, after reset";
  const Eigen::Isometry3d elsewhere = displaced(0.5, deg(90));
  EXPECT_TRUE(filter.update(1.5, exact(elsewhere, 0.01, 0.001))) << "after the gap anything goes";
  EXPECT_LT(test::translation_error_m(filter.predict(1.5)->T_camera_hand, elsewhere), 1e-9);
}

TEST(PoseFilter, IgnoresWhatIsNotATimeOrAPose) {
  PoseFilter filter;
  const PoseEstimate good = exact(at_rest(), 0.01, 0.001);
  PoseEstimate bad = good;
  bad.T_camera_hand.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(filter.update(0.0, bad));
  EXPECT_FALSE(filter.predict(0.0));
  EXPECT_TRUE(filter.update(0.0, good));
  EXPECT_FALSE(filter.update(0.0, good));
  EXPECT_FALSE(filter.update(-1.0, good));
  EXPECT_FALSE(filter.update(std::numeric_limits<double>::quiet_NaN(), good));
  EXPECT_FALSE(filter.update(0.1, bad));
  EXPECT_TRUE(filter.update(0.1, good));
  EXPECT_TRUE(filter.predict(0.1)->T_camera_hand.matrix().allFinite());
}

TEST(PoseFilter, FollowsPosesWithoutAnyDoubt) {
  const Path path = swinging(0.5);
  PoseFilter filter;
  for (int i = 0; i < 300; ++i) {
    const double t = i / 30.0;
    EXPECT_TRUE(filter.update(t, exact(path(t), 0, 0)));
    const auto pose = filter.predict(t);
    ASSERT_TRUE(pose);
    const auto error = test::pose_error(path(t), pose->T_camera_hand);
    EXPECT_LT(error.head<3>().norm(), 1e-4);
    EXPECT_LT(error.tail<3>().norm(), 1e-4);
  }
}

TEST(PoseFilter, PassesTheRawPoseThroughWhenDisabled) {
  auto rng = test::random_for("PoseFilter.PassesTheRawPoseThroughWhenDisabled");
  PoseFilterConfig config;
  config.enabled = false;
  PoseFilter filter(config);
  for (int i = 0; i < 30; ++i) {
    const PoseEstimate m = measured(swinging(1.0)(i / 30.0), deg(2), 0.002, rng);
    EXPECT_TRUE(filter.update(i / 30.0, m));
    const auto pose = filter.predict(i / 30.0);
    ASSERT_TRUE(pose);
    EXPECT_LT((pose->T_camera_hand.matrix() - m.T_camera_hand.matrix()).norm(), 1e-12);
    EXPECT_EQ(pose->velocity_m_s, Eigen::Vector3d(0, 0, 0));
    EXPECT_TRUE(pose->covariance.isApprox(m.covariance, 0.01));
  }
}

TEST(MotionState, AdvancesItsErrorsAsItself) {
  MotionState state;
  state.rotation = Eigen::Quaterniond(at_rest().linear());
  state.angular_velocity_rad_s << 1.5, -0.7, 0.4;
  state.velocity_m_s << 0.1, 0.3, -0.2;
  state.covariance.setIdentity();
  MotionState advanced = state;
  advanced.advance(0.04, 0, 0);
  MotionState::Matrix12d F;  // by central differences; covariance I becomes F F'
  const double h = 1e-5;
  for (int i = 0; i < 12; ++i) {
    MotionState plus = state, minus = state;
    plus.correct(h * MotionState::Vector12d::Unit(i));
    minus.correct(-h * MotionState::Vector12d::Unit(i));
    plus.advance(0.04, 0, 0);
    minus.advance(0.04, 0, 0);
    F.col(i) = (advanced.difference(plus) - advanced.difference(minus)) / (2 * h);
  }
  EXPECT_LT((advanced.covariance - F * F.transpose()).cwiseAbs().maxCoeff(), 1e-4);
}

}  // namespace
}  // namespace handyar
