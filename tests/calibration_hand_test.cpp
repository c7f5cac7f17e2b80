// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "calibration_scene.hpp"
#include "handyar/calibration/hand_calibration.hpp"

namespace handyar {
namespace {

using testing::axis_error_mm;
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
      0.2)
      << "it takes round tips for points";
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
  ASSERT_TRUE(m.has_valleys);
  EXPECT_NEAR((m.valleys_m(0, 1) + m.valleys_m(0, 2)) / 2, 0, 1e-12) << "y along the middle finger";
  EXPECT_LT(c.T_board_hand.linear()(2, 2), -0.999) << "z out of the board";
  EXPECT_NEAR(c.T_board_hand.linear().determinant(), 1, 1e-9);
}

TEST(CalibrateHand, WithoutValleysTheFrameComesFromTheAverageHand) {
  Scene scene;
  scene.hand.has_valleys = false;
  const HandCalibration c = calibrate_hand(scene.all(), scene.camera, scene.board);
  EXPECT_FALSE(c.by_triangulation.has_valleys);
  const Eigen::AngleAxisd turn(c.T_board_hand.linear().transpose() * scene.T_board_hand().linear());
  EXPECT_LT(std::abs(turn.angle()), 1 * kDegree);
}

TEST(CalibrateHand, ValleysAreMeasured) {
  Scene scene;
  scene.noise_px = 0.5;
  const HandCalibration c = calibrate_hand(scene.all(), scene.camera, scene.board);
  const Eigen::Isometry3d T_true_measured = scene.T_board_hand().inverse() * c.T_board_hand;
  for (int k = 0; k < kValleyCount; ++k) {
    const Eigen::Vector3d p = T_true_measured * c.by_triangulation.valleys_m.col(k);
    EXPECT_LT((p - scene.hand.valleys_m.col(k)).head<2>().norm(), 0.0005);
  }
}

TEST(CalibrateHand, AxesOfTheFingersAreMeasured) {
  Scene scene;
  auto views = scene.all();
  for (std::size_t i = 0; i < views.size(); i += 6) views[i].axes[2].root_px.x() += 10;
  const HandCalibration c = calibrate_hand(views, scene.camera, scene.board);
  ASSERT_TRUE(c.by_triangulation.has_axes);
  const Eigen::Isometry3d T_true_measured = scene.T_board_hand().inverse() * c.T_board_hand;
  for (int k = 0; k < kFingerCount; ++k)
    EXPECT_LT(axis_error_mm(c.by_triangulation, scene.hand, k, T_true_measured), 0.3) << k;
  for (CalibrationView& v : views) v.axes[4].seen = false;
  EXPECT_FALSE(calibrate_hand(views, scene.camera, scene.board).by_triangulation.has_axes);
}

// The other hand beside the board, back up as well: the same hand, mirrored.
TEST(CalibrateHand, LeftAndRightHandsAreMirrorImages) {
  Scene left, right;
  right.hand = left.hand.for_layout(Layout::thumb_left);
  const HandModel a = calibrate_hand(left.all(), left.camera, left.board).by_triangulation;
  const HandModel b = calibrate_hand(right.all(), right.camera, right.board).by_triangulation;
  EXPECT_EQ(a.layout, Layout::thumb_right);
  EXPECT_EQ(b.layout, Layout::thumb_left);
  EXPECT_LT((a.for_layout(Layout::thumb_left).tips_m - b.tips_m).norm(), 5e-4);
  EXPECT_LT((b.for_layout(Layout::thumb_right).valleys_m - a.valleys_m).norm(), 1e-3);
}

TEST(CalibrateHand, HalfTurnedBoardsAreRecognised) {
  const Scene scene;
  auto views = scene.all();
  for (std::size_t i = 0; i < views.size(); i += 3)
    std::reverse(views[i].corners_px.begin(), views[i].corners_px.end());
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

// A hand's outline for the test: a palm, an arm, and a finger to each tip.
std::vector<Eigen::Vector2d> drawn_outline(const HandModel& hand) {
  const auto tip = [&](int k) -> Eigen::Vector2d { return hand.tips_m.col(k).head<2>(); };
  std::vector<Eigen::Vector2d> corners = {{0.028, -0.25}, {0.028, -0.10}, {0.045, -0.05}};
  for (int k = 0; k < kFingerCount; ++k) {
    const Eigen::Vector2d along = (tip(k) - Eigen::Vector2d(0, -0.04)).normalized();
    const Eigen::Vector2d side(along.y(), -along.x());
    corners.push_back(tip(k) - 0.01 * along + 0.007 * side);
    corners.push_back(tip(k));
    corners.push_back(tip(k) - 0.01 * along - 0.007 * side);
    if (k < kValleyCount) corners.push_back(hand.valleys_m.col(k).head<2>());
  }
  for (const Eigen::Vector2d& p : {Eigen::Vector2d(-0.045, -0.05), Eigen::Vector2d(-0.024, -0.10),
                                   Eigen::Vector2d(-0.03, -0.25)})
    corners.push_back(p);
  std::vector<Eigen::Vector2d> dense;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d a = corners[i], b = corners[(i + 1) % corners.size()];
    for (double s = 0; s < 1; s += 0.02) dense.push_back(a + s * (b - a));
  }
  return dense;
}

TEST(CalibrateHand, OutlineRunsFromWristToWrist) {
  Scene scene;
  scene.hand.tips_m.row(2).setZero();
  auto views = scene.all();
  const auto outline = drawn_outline(scene.hand);
  for (int i = 0; i < scene.views; ++i)
    for (const Eigen::Vector2d& p : outline)
      views[i].contour_px.push_back(scene.camera
                                        .project(scene.T_camera_board(i) * scene.T_board_hand() *
                                                 Eigen::Vector3d(p.x(), p.y(), 0))
                                        .cast<float>());
  const HandModel m = calibrate_hand(views, scene.camera, scene.board).by_triangulation;
  ASSERT_GT(m.outline_m.size(), 100u);
  for (int k = 0; k < kFingerCount; ++k) {
    double nearest_m = 1;
    for (const auto& p : m.outline_m)
      nearest_m = std::min(nearest_m, (p - m.tips_m.col(k).head<2>()).norm());
    EXPECT_LT(nearest_m, 0.002) << "finger " << k;
  }
  // The arm is narrowest, 52 mm, at y = -100 mm; the first end is on the thumb's side.
  EXPECT_NEAR(m.outline_m.front().y(), -0.10, 0.004);
  EXPECT_NEAR(m.outline_m.back().y(), -0.10, 0.004);
  EXPECT_NEAR(m.outline_m.front().x() - m.outline_m.back().x(), 0.052, 0.004);
}

}  // namespace
}  // namespace handyar
