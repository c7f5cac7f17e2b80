// SPDX-License-Identifier: MIT
// Boards and markers, by which poses of the hand are judged where no truth is known.
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "evaluation_scene.hpp"
#include "handyar/calibration/board_sheet.hpp"
#include "handyar/evaluation/board_error.hpp"
#include "handyar/evaluation/rigid.hpp"
#include "handyar/evaluation/statistics.hpp"

namespace handyar::evaluation {
namespace {

/// Exact views of the board and exact poses of a thing that is fixed to it.
struct BoardScene {
  Board board{8, 6, 0.02};
  Camera camera;
  std::vector<std::optional<BoardView>> views;
  Poses T_camera_thing;
};

BoardScene make_board_scene(int frames) {
  BoardScene s;
  const Eigen::Isometry3d T_thing_board = pose({0.1, 0.2, 1.0}, {0.15, -0.05, 0.01});
  for (int i = 0; i < frames; ++i) {
    const Eigen::Isometry3d T_camera_board = hand_at(i);
    s.views.push_back(BoardView{project_board(s.board, s.camera, T_camera_board), T_camera_board});
    s.T_camera_thing.push_back(T_camera_board * T_thing_board.inverse());
  }
  return s;
}

TEST(BoardError, IsZeroForExactPosesWhateverTheTransform) {
  const BoardScene s = make_board_scene(90);
  EXPECT_LT(summarize(board_errors_px(s.board, s.camera, s.views, s.T_camera_thing)).max, 1e-5);
}

TEST(BoardError, NoFrameIsJudgedByATransformThatItHelpedToFit) {
  // The thing is turned by 1 degree in every other block: each half fits its own transform exactly,
  // so judged on itself it would have no error at all.
  BoardScene s = make_board_scene(90);
  for (std::size_t i = 0; i < 90; ++i)
    if (i / 15 % 2) *s.T_camera_thing[i] = *s.T_camera_thing[i] * pose({0, 0, kRadians}, {0, 0, 0});
  const std::vector<double> errors = board_errors_px(s.board, s.camera, s.views, s.T_camera_thing);
  for (const double px : errors) EXPECT_GT(px, 1.0);
}

TEST(BoardError, FramesWithoutBoardOrThingHaveNone) {
  BoardScene s = make_board_scene(60);
  s.views[3].reset();
  s.T_camera_thing[7].reset();
  const std::vector<double> errors = board_errors_px(s.board, s.camera, s.views, s.T_camera_thing);
  EXPECT_TRUE(std::isnan(errors[3]));
  EXPECT_TRUE(std::isnan(errors[7]));
  EXPECT_EQ(summarize(errors).n, 58);
}

TEST(Markers, OfSeveralTheOneThatIsSeenMostOftenIsFollowed) {
  const auto at = [](double x_m) { return pose({0, 0, 0}, {x_m, 0, 0.5}); };
  // The largest first: which one that is changes.
  const std::vector<std::vector<MarkerView>> frames = {
      {{3, at(1)}, {7, at(2)}}, {}, {{7, at(3)}, {3, at(4)}}, {{7, at(5)}, {7, at(6)}}};
  const Poses poses = follow_one(frames);
  ASSERT_EQ(poses.size(), 4u);
  EXPECT_EQ(poses[0]->translation().x(), 2);
  EXPECT_FALSE(poses[1]);
  EXPECT_EQ(poses[2]->translation().x(), 3);
  EXPECT_EQ(poses[3]->translation().x(), 5) << "of two with one number the larger";
  EXPECT_FALSE(follow_one(std::vector<std::vector<MarkerView>>(2))[1]);
}

/// The board before a grey wall.
cv::Mat picture_of(const Board& board, const Camera& camera, const Eigen::Isometry3d& T) {
  constexpr int kSquare_px = 40;
  std::vector<cv::Point2f> sheet, picture;
  for (const double x : {-1, board.columns})
    for (const double y : {-1, board.rows}) {
      // The sheet has a margin of a square; its corners lie between pixels.
      sheet.emplace_back(float(kSquare_px * (x + 2) - 0.5), float(kSquare_px * (y + 2) - 0.5));
      const Eigen::Vector2d px =
          camera.project(T * Eigen::Vector3d(x * board.square_m, y * board.square_m, 0));
      picture.emplace_back(float(px.x()), float(px.y()));
    }
  cv::Mat seen;
  cv::warpPerspective(board_image(board, kSquare_px), seen,
                      cv::getPerspectiveTransform(sheet, picture), {640, 480}, cv::INTER_AREA,
                      cv::BORDER_CONSTANT, cv::Scalar(110));
  return seen;
}

void expect_the_first_corner_to_stay(const Board& board) {
  const Camera camera;
  BoardFinder finder(board, camera);
  std::vector<Eigen::Isometry3d> T_true_found;
  int read_from_another_corner = 0;
  for (int degrees = 0; degrees <= 360; degrees += 20) {
    const Eigen::Isometry3d T =
        pose({0, 0, degrees * kRadians}, {0, 0, 0.35}) * Eigen::Translation3d(-board.centre_m());
    const cv::Mat picture = picture_of(board, camera, T);
    const std::optional<BoardView> view = finder.find(picture);
    ASSERT_TRUE(view) << degrees;
    T_true_found.push_back(T.inverse() * view->T_camera_board);
    EXPECT_LT(angle_between(T_true_found.back().linear(), T_true_found[0].linear()), kRadians)
        << degrees;
    EXPECT_LT(rms_distance_px(project_board(board, camera, view->T_camera_board), view->corners_px),
              0.3);
    const cv::Point2f first = find_board(picture, board).front();
    read_from_another_corner +=
        (Eigen::Vector2d(first.x, first.y) - view->corners_px[0]).norm() > 5;
  }
  EXPECT_GT(read_from_another_corner, 0) << "or the test shows nothing";
}

TEST(BoardFinder, TheFirstCornerStaysWhileTheBoardTurns) {
  expect_the_first_corner_to_stay({8, 6, 0.02});
  expect_the_first_corner_to_stay({6, 6, 0.02});  // four corners are alike
  expect_the_first_corner_to_stay({7, 7, 0.02});
}

}  // namespace
}  // namespace handyar::evaluation
