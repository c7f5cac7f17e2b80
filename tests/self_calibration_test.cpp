// SPDX-License-Identifier: MIT
#include "handyar/calibration/self_calibration.hpp"

#include <gtest/gtest.h>

#include "calibration_scene.hpp"
#include "handyar/stages/hand_figure.hpp"

namespace handyar {
namespace {

using testing::Scene;
using testing::tips_rms_mm;

/// A hand that is not the average one turns before the camera, and a tracker that learns it.
struct TurningHand : Scene {
  FigureEstimate figure;

  TurningHand() {
    views = 150;
    figure.mean.head<4>() << 0.8, -1.0, 0.7, 0.5;
    figure.covariance *= 0.01;
    hand = hand_of_figure(figure, Layout::thumb_right);
    hand.average_scale = true;
  }
  Eigen::Isometry3d T_camera_hand(int i) const {
    const double s = 2 * M_PI * i / views;
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = (Eigen::AngleAxisd(tilt_rad * std::sin(2 * s), Eigen::Vector3d::UnitX()) *
                  Eigen::AngleAxisd(tilt_rad * std::cos(s), Eigen::Vector3d::UnitY()))
                     .toRotationMatrix() *
                 Eigen::Vector3d(1, -1, -1).asDiagonal();
    T.translation() << 0.04 * std::cos(2 * s), 0.03 + 0.02 * std::sin(s), 0.45 + 0.1 * std::sin(s);
    return T;
  }
  /// What is learned goes from people's mean to the hand's own figure within the first third.
  std::vector<CalibrationView> all() const {
    std::vector<CalibrationView> out;
    for (int i = 0; i < views; ++i) {
      CalibrationView v;
      v.T_camera_hand = T_camera_hand(i);
      for (int k = 0; k < kFingerCount; ++k)
        v.tips[k] = {camera.project(*v.T_camera_hand * hand.tips_m.col(k).eval()), true};
      FigureEstimate learned = figure;
      learned.mean *= std::min(1.0, 3.0 * i / views);
      v.hand = hand_of_figure(learned, hand.layout);
      out.push_back(v);
    }
    return out;
  }
};

TEST(SelfCalibrate, GivesTheLearnedShapeTheKnownLength) {
  const TurningHand scene;
  const auto views = scene.all();
  const SelfCalibration c =
      self_calibrate_hand(views, scene.camera, {.span_m = scene.hand.span_m()});
  EXPECT_LT(tips_rms_mm(c.hand, scene.hand), 0.5);
  EXPECT_NEAR(c.hand.span_m(), scene.hand.span_m(), 0.0005);
  EXPECT_FALSE(c.hand.scale_assumed());
  EXPECT_EQ(c.hand.source, HandSource::self);
  EXPECT_GT(c.turned_rad, 0.8);
  const SelfCalibration larger =
      self_calibrate_hand(views, scene.camera, {.span_m = 1.1 * scene.hand.span_m()});
  EXPECT_NEAR(larger.hand.span_m() / c.hand.span_m(), 1.1, 0.01);
  const SelfCalibration assumed = self_calibrate_hand(views, scene.camera);
  EXPECT_TRUE(assumed.hand.scale_assumed());
  EXPECT_NEAR(assumed.hand.span_m() / scene.hand.span_m(), 1 / relative_size(scene.figure.mean),
              0.01);
  const auto of_length = [&](double length_m) {
    return self_calibrate_hand(views, scene.camera, {.hand_length_m = length_m}).hand;
  };
  EXPECT_FALSE(of_length(0.19).scale_assumed());
  EXPECT_NEAR(of_length(0.19).span_m() / of_length(0.17).span_m(), 0.19 / 0.17, 0.01);
}

TEST(SelfCalibrate, TheKnownLengthIsThatOfTheHandAsItWasSpread) {
  const TurningHand scene;
  auto views = scene.all();
  Posture together;
  for (int f = 0; f < kFingerCount; ++f) together.abduction_rad[f] = 0.7 * closing_rad()[f];
  for (CalibrationView& view : views) view.posture = together;
  const HandFigure figure = make_figure(scene.figure.mean, Face::palm, Layout::thumb_right);
  const auto tips_m = pose_fingers(figure, together).tips_m;
  const SelfCalibration c = self_calibrate_hand(
      views, scene.camera, {.span_m = (tips_m.col(0) - tips_m.col(kFingerCount - 1)).norm()});
  EXPECT_NEAR(c.hand.span_m(), scene.hand.span_m(), 0.0005);
}

std::string refused(const std::vector<CalibrationView>& views, const Camera& camera) {
  return testing::refusal<CalibrationError>([&] { self_calibrate_hand(views, camera); });
}

TEST(SelfCalibrate, RefusesAHandThatDoesNotTurn) {
  TurningHand scene;
  scene.tilt_rad = 0.08;
  const std::string why = refused(scene.all(), scene.camera);
  EXPECT_NE(why.find("one side only"), std::string::npos) << why;
}

TEST(SelfCalibrate, RefusesAShapeThatGoesOnChanging) {
  const TurningHand scene;
  auto views = scene.all();
  for (int i = 0; i < scene.views; ++i) {
    FigureEstimate learned = scene.figure;
    learned.mean[0] += 8.0 * i / scene.views;
    learned.mean[2] += 8.0 * i / scene.views;
    views[i].hand = hand_of_figure(learned, scene.hand.layout);
  }
  const std::string why = refused(views, scene.camera);
  EXPECT_NE(why.find("tell different hands"), std::string::npos) << why;
}

TEST(SelfCalibrate, RefusesALengthThatNoHandHas) {
  const TurningHand scene;
  const auto views = scene.all();
  const std::string why = testing::refusal<CalibrationError>(
      [&] { self_calibrate_hand(views, scene.camera, {.span_m = 0.35}); });
  EXPECT_NE(why.find("350 mm"), std::string::npos) << why;
}

TEST(SelfCalibrate, RefusesARecordingWithoutHand) {
  const std::string why = refused(std::vector<CalibrationView>(100), Camera{});
  EXPECT_NE(why.find("seen in 0 of 100 frames"), std::string::npos) << why;
}

}  // namespace
}  // namespace handyar
