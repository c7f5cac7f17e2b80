// SPDX-License-Identifier: MIT
#include "handyar/calibration/self_calibration.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "calibration_scene.hpp"

namespace handyar {
namespace {

using testing::axis_error_mm;
using testing::Scene;
using testing::tips_rms_mm;

// A hand that is not the average one and turns before the camera.
struct TurningHand : Scene {
  TurningHand() {
    views = 150;
    hand.tips_m.topRows<2>() << 0.101, 0.040, 0.000, -0.041, -0.080,  //
        0.000, 0.086, 0.104, 0.088, 0.048;
  }
  Eigen::Isometry3d T_camera_hand(int i) const {
    const double s = 2 * M_PI * i / views;
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = (Eigen::AngleAxisd(tilt_rad * std::sin(2 * s), Eigen::Vector3d::UnitX()) *
                  Eigen::AngleAxisd(tilt_rad * std::cos(s), Eigen::Vector3d::UnitY()) *
                  Eigen::AngleAxisd(0.3 * std::sin(3 * s), Eigen::Vector3d::UnitZ()))
                     .toRotationMatrix() *
                 Eigen::Vector3d(1, -1, -1).asDiagonal();
    T.translation() << 0.04 * std::cos(2 * s), 0.03 + 0.02 * std::sin(s), 0.45 + 0.1 * std::sin(s);
    return T;
  }
  std::vector<CalibrationView> all() const {
    std::mt19937 random = testing::test_random();
    std::normal_distribution<double> normal;
    std::vector<CalibrationView> out;
    for (int i = 0; i < views; ++i) {
      CalibrationView v;
      const auto seen = [&](const Eigen::Vector3d& p) {
        return Tip{camera.project(T_camera_hand(i) * p) +
                       noise_px * Eigen::Vector2d(normal(random), normal(random)),
                   true};
      };
      for (int k = 0; k < kFingerCount; ++k) v.tips[k] = seen(hand.tips_m.col(k));
      for (int k = 0; k < kValleyCount && hand.has_valleys; ++k)
        v.valleys[k] = seen(hand.valleys_m.col(k));
      for (int k = 0; k < kFingerCount && hand.has_axes; ++k)
        v.axes[k] = {camera.project(T_camera_hand(i) * hand.axis_ends_m.col(k).eval()),
                     camera.project(T_camera_hand(i) * hand.axis_roots_m.col(k).eval()), true};
      out.push_back(v);
    }
    return out;
  }
};

TEST(SelfCalibrate, FindsTheShapeInExactViews) {
  const TurningHand scene;
  const SelfCalibration c =
      self_calibrate_hand(scene.all(), scene.camera, {.span_m = scene.hand.span_m()});
  EXPECT_LT(tips_rms_mm(c.hand, scene.hand), 0.1);
  EXPECT_NEAR(c.hand.span_m(), scene.hand.span_m(), 1e-9);
  EXPECT_FALSE(c.hand.scale_assumed());
  EXPECT_EQ(c.hand.source, HandSource::self);
  EXPECT_EQ(c.hand.layout, Layout::thumb_right);
  EXPECT_TRUE(c.hand.has_valleys);
  EXPECT_GT(c.turned_rad, 0.8);
  ASSERT_TRUE(c.hand.has_axes);
  const Eigen::Isometry3d T_true_measured(Eigen::umeyama(c.hand.tips_m, scene.hand.tips_m, false));
  for (int k = 0; k < kFingerCount; ++k)
    EXPECT_LT(axis_error_mm(c.hand, scene.hand, k, T_true_measured), 0.5) << k;
}

TEST(SelfCalibrate, NoisyTipsAloneAreEnough) {
  TurningHand scene;
  scene.noise_px = 1.0;
  scene.hand.has_valleys = false;
  auto views = scene.all();
  for (std::size_t i = 0; i < views.size(); i += 9) views[i].tips[4].px.y() += 30;
  const SelfCalibration c =
      self_calibrate_hand(views, scene.camera, {.span_m = scene.hand.span_m()});
  EXPECT_LT(tips_rms_mm(c.hand, scene.hand), 1.5) << "1 % of the hand's width";
  EXPECT_FALSE(c.hand.has_valleys);
  EXPECT_GT(c.hand.tips_sigma_m.minCoeff(), 0);
  EXPECT_LT(c.hand.tips_sigma_m.maxCoeff(), 0.003);
}

TEST(SelfCalibrate, TheOtherLayoutIsItsMirrorImage) {
  TurningHand scene;
  const HandModel truth = scene.hand;
  scene.hand = truth.for_layout(Layout::thumb_left);
  const SelfCalibration c =
      self_calibrate_hand(scene.all(), scene.camera, {.span_m = truth.span_m()});
  EXPECT_EQ(c.hand.layout, Layout::thumb_left);
  EXPECT_LT(tips_rms_mm(c.hand.for_layout(Layout::thumb_right), truth), 0.1);
}

TEST(SelfCalibrate, WithoutALengthTheSizeIsTheAverageAdults) {
  const TurningHand scene;
  const auto views = scene.all();
  const SelfCalibration assumed = self_calibrate_hand(views, scene.camera);
  EXPECT_TRUE(assumed.hand.scale_assumed());
  EXPECT_NEAR(fit_average_hand(assumed.hand.tips_m.topRows<2>()).scale, 1, 1e-9);
  const SelfCalibration measured =
      self_calibrate_hand(views, scene.camera, {.hand_length_m = 0.200});
  EXPECT_FALSE(measured.hand.scale_assumed());
  EXPECT_NEAR(measured.hand.span_m() / assumed.hand.span_m(), 200.0 / 187.0, 1e-9);
}

std::string refused(const std::vector<CalibrationView>& views, const Camera& camera) {
  return testing::refusal<CalibrationError>([&] { self_calibrate_hand(views, camera); });
}

TEST(SelfCalibrate, RefusesAHandThatDoesNotTurn) {
  TurningHand scene;
  scene.tilt_rad = 0.08;
  scene.noise_px = 0.3;
  const std::string why = refused(scene.all(), scene.camera);
  EXPECT_NE(why.find("one side only"), std::string::npos) << why;
}

TEST(SelfCalibrate, RefusesFingersThatMove) {
  const TurningHand scene;
  auto views = scene.all();
  for (int i = 0; i < scene.views; ++i)
    for (int k = 0; k < kFingerCount; ++k)
      views[i].tips[k].px.x() += 18 * std::sin(0.7 * i + 2 * k);
  const std::string why = refused(views, scene.camera);
  EXPECT_NE(why.find("did not keep their places"), std::string::npos) << why;
}

TEST(SelfCalibrate, RefusesARecordingWithoutHand) {
  const std::string why = refused(std::vector<CalibrationView>(100), Camera{});
  EXPECT_NE(why.find("seen in 0 of 100 frames"), std::string::npos) << why;
}

}  // namespace
}  // namespace handyar
