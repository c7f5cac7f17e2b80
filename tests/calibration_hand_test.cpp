// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "calibration_scene.hpp"
#include "handyar/calibration/hand_calibration.hpp"
#include "handyar/stages/hand_figure.hpp"

namespace handyar {
namespace {

using testing::Scene;
using testing::tips_rms_mm;

constexpr double kDegree = M_PI / 180;

std::string refused(const std::vector<CalibrationView>& views, const Scene& scene,
                    const Board& board) {
  return testing::refusal<CalibrationError>([&] { calibrate_hand(views, scene.camera, board); });
}

TEST(CalibrateHand, TriangulatesExactTips) {
  const Scene scene;
  const HandCalibration c = calibrate_hand(scene.all(), scene.camera, scene.board);
  EXPECT_LT(tips_rms_mm(c.by_triangulation, scene.hand), 0.05);
  for (int k = 0; k < kFingerCount; ++k)
    EXPECT_NEAR(c.by_triangulation.tips_m(2, k), scene.hand.tips_m(2, k), 0.0006)
        << "drawn a little towards the common height";
  EXPECT_NEAR(c.height_m, scene.height_m, 0.0002);
  EXPECT_EQ(c.by_triangulation.thickness_m, c.height_m);
  EXPECT_EQ(c.by_triangulation.layout, Layout::thumb_right);
  EXPECT_EQ(c.by_triangulation.source, HandSource::checkerboard);
}

TEST(CalibrateHand, ThePapersWayIsExactAtTheRightHeightOnly) {
  Scene scene;
  scene.hand.tips_m.row(2).setZero();
  const auto views = scene.all();
  EXPECT_LT(
      tips_rms_mm(calibrate_hand(views, scene.camera, scene.board, 0.011).by_plane, scene.hand),
      0.05);
  const HandCalibration wrong = calibrate_hand(views, scene.camera, scene.board, 0.0);
  EXPECT_GT(wrong.rms_difference_m, 1e-4);
  EXPECT_LT(tips_rms_mm(wrong.by_triangulation, scene.hand), 0.05) << "assumes no thickness";
}

TEST(CalibrateHand, NoiseAndOutliersStayWithinAMillimetreAndTheDeviationsSaySo) {
  Scene scene;
  scene.noise_px = 0.7;
  auto views = scene.all();
  for (std::size_t i = 0; i < views.size(); i += 6) views[i].tips[1].px.x() += 25;
  const HandCalibration c = calibrate_hand(views, scene.camera, scene.board);
  EXPECT_LT(tips_rms_mm(c.by_triangulation, scene.hand), 0.5);
  EXPECT_LT(tips_rms_mm(c.by_plane, scene.hand), 1.5);
  const Eigen::Matrix3Xd error = c.by_triangulation.tips_m - scene.hand.tips_m;
  for (int k = 0; k < kFingerCount; ++k)
    for (int a = 0; a < 3; ++a) {
      EXPECT_GT(c.by_triangulation.tips_sigma_m(a, k), 1e-4);
      EXPECT_LT(c.by_triangulation.tips_sigma_m(a, k), 4e-3);
      EXPECT_LT(std::abs(error(a, k)), 4 * c.by_triangulation.tips_sigma_m(a, k) + 0.001);
    }
}

TEST(CalibrateHand, FrameIsThePapersFigure5) {
  const Scene scene;
  const HandCalibration c = calibrate_hand(scene.all(), scene.camera, scene.board);
  const HandModel& m = c.by_triangulation;
  EXPECT_NEAR(m.tips_m(0, 2), 0, 1e-12) << "x of the middle fingertip";
  EXPECT_NEAR(m.tips_m(1, 0), 0, 1e-12) << "y of the thumb tip";
  EXPECT_NEAR(m.tips_m.row(2).mean(), 0, 1e-12);
  EXPECT_LT(c.T_board_hand.linear()(2, 2), -0.999) << "z out of the board";
  EXPECT_NEAR(c.T_board_hand.linear().determinant(), 1, 1e-9);
}

TEST(CalibrateHand, TheFrameIsTheSameWithoutWebs) {
  Scene scene;
  for (const bool webs : {true, false}) {
    scene.webs_seen = webs;
    const HandCalibration c = calibrate_hand(scene.all(), scene.camera, scene.board);
    const Eigen::AngleAxisd turn(c.T_board_hand.linear().transpose() *
                                 scene.T_board_hand().linear());
    EXPECT_LT(std::abs(turn.angle()), 1 * kDegree) << webs;
  }
}

TEST(CalibrateHand, TellsTheFigure) {
  const Scene scene;
  const HandModel hand = calibrate_hand(scene.all(), scene.camera, scene.board).by_triangulation;
  ASSERT_TRUE(hand.figure);
  EXPECT_LT(tips_rms_mm(hand_of_figure(*hand.figure, hand.layout), scene.hand), 2);
  EXPECT_LT(hand.figure->covariance.trace(), 0.8 * kFigureModes) << "more than people at large";
}

// The other hand beside the board, back up as well: the same hand, mirrored.
TEST(CalibrateHand, LeftAndRightHandsAreMirrorImages) {
  Scene left, right;
  right.hand = left.hand.for_layout(Layout::thumb_left);
  right.webs_m.row(0) *= -1;
  const HandModel a = calibrate_hand(left.all(), left.camera, left.board).by_triangulation;
  const HandModel b = calibrate_hand(right.all(), right.camera, right.board).by_triangulation;
  EXPECT_EQ(a.layout, Layout::thumb_right);
  EXPECT_EQ(b.layout, Layout::thumb_left);
  EXPECT_LT((a.for_layout(Layout::thumb_left).tips_m - b.tips_m).norm(), 5e-4);
}

TEST(CalibrateHand, HalfTurnedBoardsAreRecognised) {
  const Scene scene;
  auto views = scene.all();
  for (std::size_t i = 0; i < views.size(); i += 3)
    std::reverse(views[i].corners_px.begin(), views[i].corners_px.end());
  const HandCalibration c = calibrate_hand(views, scene.camera, scene.board);
  EXPECT_LT(tips_rms_mm(c.by_triangulation, scene.hand), 0.05);
}

TEST(CalibrateHand, SquareBoardsThatAreQuarterTurnedAreRecognised) {
  constexpr int kCorners = 7;
  Scene scene;
  scene.board = {kCorners, kCorners, 0.022};
  auto views = scene.all();
  for (std::size_t i = 0; i < views.size(); ++i)
    for (std::size_t turn = 0; turn < i % 4; ++turn) {
      const auto before = views[i].corners_px;
      for (int row = 0; row < kCorners; ++row)
        for (int column = 0; column < kCorners; ++column)
          views[i].corners_px[row * kCorners + column] =
              before[column * kCorners + kCorners - 1 - row];
    }
  const HandCalibration c = calibrate_hand(views, scene.camera, scene.board);
  EXPECT_LT(tips_rms_mm(c.by_triangulation, scene.hand), 0.05);
}

TEST(CalibrateHand, RefusesAHandThatMoved) {
  const Scene scene;
  auto views = scene.all();
  Scene moved = scene;
  moved.hand.tips_m.row(0).array() += 0.012;
  const auto later = moved.all();
  std::copy(later.begin() + 45, later.end(), views.begin() + 45);
  EXPECT_NE(refused(views, scene, scene.board).find("the hand moved"), std::string::npos);
}

TEST(CalibrateHand, RefusesAFingerThatMovedToAndFro) {
  const Scene scene;
  auto views = scene.all();
  Scene moved = scene;
  moved.hand.tips_m(0, 1) += 0.015;
  const auto other = moved.all();
  for (std::size_t i = 0; i < views.size(); i += 2) views[i] = other[i];
  const std::string why = refused(views, scene, scene.board);
  EXPECT_NE(why.find("index"), std::string::npos) << why;
}

TEST(CalibrateHand, RefusesAWrongSquareSize) {
  const Scene scene;
  Board board = scene.board;
  board.square_m = 0.060;
  const std::string why = refused(scene.all(), scene, board);
  EXPECT_NE(why.find("squares really 60 mm"), std::string::npos) << why;
}

TEST(CalibrateHand, RefusesARecordingWithoutHand) {
  const Scene scene;
  auto views = scene.all();
  for (auto& v : views) v.tips = {};
  EXPECT_NE(refused(views, scene, scene.board).find("together in 0 frames"), std::string::npos);
}

}  // namespace
}  // namespace handyar
