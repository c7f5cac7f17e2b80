// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "calibration_scene.hpp"
#include "handyar/calibration/camera_calibration.hpp"

namespace handyar {
namespace {

using testing::Scene;

const cv::Size kSize(640, 480);

std::string refused(const std::vector<CalibrationView>& views, const Board& board) {
  return testing::refusal<CalibrationError>([&] { calibrate_camera(views, board, kSize); });
}

TEST(CalibrateCamera, FindsTheCameraInExactViews) {
  const Scene scene;
  const CameraCalibration c = calibrate_camera(scene.all(), scene.board, kSize);
  EXPECT_NEAR(c.camera.fx_px, 618, 0.05);
  EXPECT_NEAR(c.camera.cx_px, 322.4, 0.05);
  EXPECT_NEAR(c.camera.cy_px, 236.9, 0.05);
  EXPECT_LT(c.rms_px, 1e-3);
  EXPECT_EQ(c.camera.width_px, 640);
  EXPECT_EQ(c.camera.height_px, 480);
  EXPECT_FALSE(c.camera.assumed);
}

TEST(CalibrateCamera, WithNoiseStaysWithinItsOwnDeviations) {
  Scene scene;
  scene.corner_noise_px = 0.15;
  const CameraCalibration c = calibrate_camera(scene.all(), scene.board, kSize);
  EXPECT_LT(std::abs(c.camera.fx_px - 618), 4 * c.focal_sigma_px);
  EXPECT_LT(c.focal_sigma_px, 3);
  EXPECT_LT(std::abs(c.camera.cx_px - 322.4), 4 * c.centre_sigma_px);
  EXPECT_LT(std::abs(c.camera.cy_px - 236.9), 4 * c.centre_sigma_px);
  EXPECT_EQ(c.distortion, "none") << "noise must not be taken for distortion";
  EXPECT_LE(c.views_used.size(), static_cast<std::size_t>(kMaxViews));
}

TEST(CalibrateCamera, FindsDistortionAndPixelsThatAreNotSquare) {
  Scene scene;
  scene.camera.distortion = {-0.28, 0.11, 0.001, -0.0008, 0};
  scene.camera.fy_px = 590;
  scene.corner_noise_px = 0.05;
  const CameraCalibration c = calibrate_camera(scene.all(), scene.board, kSize);
  EXPECT_NEAR(c.camera.fx_px, 618, 4);
  EXPECT_NEAR(c.camera.fy_px, 590, 4);
  EXPECT_NEAR(c.camera.distortion[0], -0.28, 0.03);
  EXPECT_LT(c.rms_px, 0.1);
}

TEST(CalibrateCamera, LeavesAViewWithBentCornersOut) {
  Scene scene;
  scene.corner_noise_px = 0.05;
  auto views = scene.all();
  for (int i : {7, 33}) {
    std::mt19937 random = testing::test_random();
    std::normal_distribution<float> bend(0, 3);
    for (auto& c : views[i].corners_px) c += cv::Point2f(bend(random), bend(random));
  }
  const CameraCalibration c = calibrate_camera(views, scene.board, kSize);
  EXPECT_NEAR(c.camera.fx_px, 618, 3);
  EXPECT_LT(c.rms_px, 0.1);
  for (int i : {7, 33}) EXPECT_EQ(std::count(c.views_used.begin(), c.views_used.end(), i), 0);
}

TEST(CalibrateCamera, RefusesARecordingWithoutBoard) {
  auto views = Scene{}.all();
  for (auto& v : views) v.corners_px.clear();
  EXPECT_NE(refused(views, Board{}).find("seen in 0 of 90 frames"), std::string::npos);
}

TEST(CalibrateCamera, RefusesTooFewViews) {
  auto views = Scene{}.all();
  views.resize(kMinViews - 1);
  EXPECT_NE(refused(views, Scene{}.board).find("10 are needed"), std::string::npos);
}

TEST(CalibrateCamera, RefusesViewsThatAreAllTheSame) {
  const Scene scene;
  const std::vector<CalibrationView> views(50, scene.all()[12]);
  EXPECT_NE(refused(views, scene.board).find("one side only"), std::string::npos);
}

TEST(CalibrateCamera, RefusesViewsFromOneSide) {
  Scene scene;
  scene.tilt_rad = 0.05;
  scene.corner_noise_px = 0.1;
  EXPECT_NE(refused(scene.all(), scene.board).find("one side only"), std::string::npos);
}

TEST(CalibrateCamera, RefusesATinyBoard) {
  Scene scene;
  scene.board.square_m = 0.006;
  EXPECT_NE(refused(scene.all(), scene.board).find("too small"), std::string::npos);
}

TEST(CalibrateCamera, RefusesBlur) {
  auto views = Scene{}.all();
  for (auto& v : views) v.blur_px = 9;
  EXPECT_NE(refused(views, Scene{}.board).find("blurred in 90 of the 90"), std::string::npos);
}

TEST(CalibrateCamera, RefusesARollingShutterInMotion) {
  auto views = Scene{}.all();
  std::mt19937 random = testing::test_random();
  std::uniform_real_distribution<float> speed(-0.3f, 0.3f);  // pixels sideways from row to row
  for (auto& v : views) {
    const float a = speed(random), b = speed(random);
    for (auto& c : v.corners_px) c += cv::Point2f(a * (c.y - 240), b * (c.y - 240) * 0.5f);
  }
  const std::string why = refused(views, Scene{}.board);
  EXPECT_NE(why.find("rolling shutter"), std::string::npos) << why;
}

}  // namespace
}  // namespace handyar
