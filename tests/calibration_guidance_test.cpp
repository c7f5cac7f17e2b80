// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "calibration_scene.hpp"
#include "handyar/calibration/guidance.hpp"
#include "handyar/calibration/picture.hpp"

namespace handyar {
namespace {

using testing::Scene;

const cv::Size kSize(640, 480);

// A view of the board alone, tilted about the picture's axes (radians), at a place (metres).
CalibrationView looked_from(double about_x, double about_y, double x_m = 0, double y_m = 0,
                            double z_m = 0.5) {
  const Scene scene;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = (Eigen::AngleAxisd(about_x, Eigen::Vector3d::UnitX()) *
                Eigen::AngleAxisd(about_y, Eigen::Vector3d::UnitY()))
                   .toRotationMatrix();
  T.translation() = Eigen::Vector3d(x_m, y_m, z_m) - T.linear() * scene.board.centre_m();
  CalibrationView v;
  v.blur_px = 2;
  for (const cv::Point3f& c : scene.board.corners_m()) {
    const Eigen::Vector2d px = scene.camera.project(T * Eigen::Vector3d(c.x, c.y, c.z));
    v.corners_px.emplace_back(static_cast<float>(px.x()), static_cast<float>(px.y()));
  }
  for (Tip& t : v.tips) t = {{100, 100}, true};
  return v;
}

TEST(Coverage, TellsTheSides) {
  struct Case {
    double about_x, about_y;
    BoardSide side;
  };
  // The board's far edge sinks away (turned about x by a negative angle) when the camera comes from
  // the near side; its right edge goes away (about y, negative) when it comes from the left.
  for (const Case& c :
       {Case{0, 0, BoardSide::above}, Case{-0.5, 0, BoardSide::near}, Case{0.5, 0, BoardSide::far},
        Case{0, -0.5, BoardSide::left}, Case{0, 0.5, BoardSide::right}}) {
    Coverage coverage(Scene{}.board, kSize);
    coverage.add(looked_from(c.about_x, c.about_y));
    for (int s = 0; s < kSideCount; ++s)
      EXPECT_EQ(coverage.views_from(static_cast<BoardSide>(s)), static_cast<BoardSide>(s) == c.side)
          << "turned by " << c.about_x << ", " << c.about_y << ", side " << kSideNames[s];
  }
}

TEST(Coverage, CountsNeitherRepeatsNorBlur) {
  Coverage coverage(Scene{}.board, kSize);
  CalibrationView v = looked_from(0, 0);
  coverage.add(v);
  coverage.add(v);
  EXPECT_EQ(coverage.views(), 1);
  v = looked_from(0.4, 0);
  v.blur_px = 8;
  coverage.add(v);
  EXPECT_EQ(coverage.views(), 1);
}

TEST(Advice, LeadsFromNothingToDone) {
  Coverage coverage(Scene{}.board, kSize);
  EXPECT_EQ(advice(coverage, {}), "Show the whole board.");
  CalibrationView v = looked_from(0, 0);
  v.tips[3].seen = false;
  EXPECT_NE(advice(coverage, v).find("Lay the hand"), std::string::npos);
  EXPECT_EQ(advice(coverage, looked_from(0, 0)), "Look from above.");
  std::string said;
  for (int i = 0; i < 40 && !coverage.done(); ++i) {
    said = advice(coverage, looked_from(0, 0));
    double x = 0, y = 0, place_x = 0.03 * (i % 3 - 1), place_y = 0.02 * (i % 4);
    if (said.find("near") != std::string::npos) x = -0.5;
    if (said.find("far side") != std::string::npos) x = 0.5;
    if (said == "Look from the left.") y = -0.5;
    if (said == "Look from the right.") y = 0.5;
    if (said.find("of the picture") != std::string::npos) {
      place_x = said.find("left") != std::string::npos ? -0.16 : 0.16;
      place_y = said.find("top") != std::string::npos      ? -0.12
                : said.find("bottom") != std::string::npos ? 0.12
                                                           : 0;
    }
    const double z = said.find("nearer") != std::string::npos ? 0.4 + 0.1 * (i % 5) : 0.5;
    coverage.add(looked_from(x + 0.02 * (i % 5), y, place_x, place_y, z));
  }
  EXPECT_TRUE(coverage.done()) << "last advice: " << said << " " << coverage.views() << " views, "
                               << coverage.sides_seen() << " sides, " << coverage.cells_share();
  EXPECT_EQ(advice(coverage, {}), "Done.");
}

TEST(Advice, OfACameraAloneAsksForNoHand) {
  Coverage camera_alone(Scene{}.board, kSize, false), both(Scene{}.board, kSize);
  CalibrationView v;
  for (const auto& [about_x, about_y] :
       {std::pair(0.0, 0.0), {-0.5, 0.0}, {0.5, 0.0}, {0.0, -0.5}, {0.0, 0.5}})
    for (const double x_m : {-0.14, 0.0, 0.14})
      for (const double y_m : {-0.1, 0.1}) {
        v = looked_from(about_x, about_y, x_m, y_m);
        v.tips = {};
        EXPECT_EQ(advice(camera_alone, v).find("hand"), std::string::npos);
        camera_alone.add(v);
        both.add(v);
      }
  EXPECT_TRUE(camera_alone.done());
  EXPECT_FALSE(both.done());
  EXPECT_NE(advice(both, v).find("Lay the hand"), std::string::npos);
}

TEST(DrawGuidance, ShowsFrameAndPanel) {
  Coverage coverage(Scene{}.board, kSize);
  const cv::Mat frame(480, 640, CV_8UC3, cv::Scalar(90, 90, 90));
  const cv::Mat empty = draw_guidance(frame, coverage, {});
  EXPECT_GT(empty.cols, frame.cols);
  EXPECT_GT(empty.rows, frame.rows);
  coverage.add(looked_from(0, 0));
  const cv::Mat one = draw_guidance(frame, coverage, {});
  EXPECT_GT(cv::norm(empty, one, cv::NORM_L1), 1000) << "cells and a side turn green";
}

TEST(DrawHand, IsToScaleAndMarksTipsAndBoard) {
  Scene scene;
  scene.hand.tips_sigma_m.setConstant(0.001);
  const cv::Mat with_board =
      draw_hand({scene.hand, scene.board, scene.T_board_hand(), std::nullopt});
  const cv::Mat alone = draw_hand({scene.hand, std::nullopt, {}, std::nullopt});
  EXPECT_EQ(alone.type(), CV_8UC3);
  EXPECT_GT(with_board.cols, alone.cols);
  // 4000 pixels a metre, 25 mm of margin on both sides.
  const double width_m = scene.hand.tips_m(0, 0) - scene.hand.tips_m(0, 4);
  EXPECT_NEAR(alone.cols, 4000 * (width_m + 0.05), 2);
}

}  // namespace
}  // namespace handyar
