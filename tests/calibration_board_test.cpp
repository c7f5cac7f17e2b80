// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <clocale>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <regex>

#include "calibration_scene.hpp"
#include "handyar/calibration/board.hpp"
#include "handyar/calibration/board_sheet.hpp"
#include "handyar/calibration/error.hpp"
#include "handyar/calibration/session.hpp"

namespace handyar {
namespace {

using testing::Scene;

// A photograph of the board, its corners known: seen through a camera, blurred, with noise.
struct Photograph {
  cv::Mat grey;
  std::vector<cv::Point2f> corners_px;
};

Photograph photograph(const Board& board, int view, double blur_px = 0.7) {
  constexpr int kSquare_px = 60, kFiner = 4;
  const Scene scene;
  const Eigen::Isometry3d T = scene.T_camera_board(view);
  Photograph out;
  std::vector<cv::Point2f> sheet, fine;
  for (const cv::Point3f& c : board.corners_m()) {
    const Eigen::Vector2d px = scene.camera.project(T * Eigen::Vector3d(c.x, c.y, c.z));
    out.corners_px.emplace_back(static_cast<float>(px.x()), static_cast<float>(px.y()));
    fine.emplace_back(out.corners_px.back() * kFiner + cv::Point2f(1.5f, 1.5f));
    // Corner (0, 0) of the sheet lies between pixels.
    sheet.emplace_back(
        c.x / static_cast<float>(board.square_m) * kSquare_px + 2 * kSquare_px - 0.5f,
        c.y / static_cast<float>(board.square_m) * kSquare_px + 2 * kSquare_px - 0.5f);
  }
  cv::Mat large;
  cv::warpPerspective(board_image(board, kSquare_px), large, cv::findHomography(sheet, fine),
                      {640 * kFiner, 480 * kFiner}, cv::INTER_LINEAR, cv::BORDER_CONSTANT,
                      cv::Scalar(110));
  cv::GaussianBlur(large, large, {}, blur_px * kFiner);
  cv::resize(large, out.grey, {640, 480}, 0, 0, cv::INTER_AREA);
  cv::Mat noise(out.grey.size(), CV_16S);
  cv::theRNG().state = 7;
  cv::randn(noise, 0, 3);
  cv::add(out.grey, noise, out.grey, {}, CV_8U);
  return out;
}

TEST(FindBoard, CornersAreSubPixel) {
  const Board board{8, 6, 0.022};
  double sum = 0;
  int n = 0;
  for (int view = 0; view < 90; view += 9) {
    const Photograph p = photograph(board, view);
    auto found = find_board(p.grey, board);
    ASSERT_EQ(found.size(), 48u) << "view " << view;
    if (cv::norm(found[0] - p.corners_px[0]) > 20) std::reverse(found.begin(), found.end());
    for (std::size_t i = 0; i < found.size(); ++i, ++n)
      sum += std::pow(cv::norm(found[i] - p.corners_px[i]), 2);
  }
  EXPECT_LT(std::sqrt(sum / n), 0.1) << "pixels rms";
}

TEST(FindBoard, AxesAreRightHandedWithZIntoTheBoard) {
  const Board board{8, 6, 0.022};
  const Scene scene;
  for (bool mirrored_order : {false, true}) {
    cv::Mat grey = photograph(board, 20).grey;
    if (mirrored_order) cv::rotate(grey, grey, cv::ROTATE_90_CLOCKWISE);
    const auto c = find_board(grey, board);
    ASSERT_EQ(c.size(), 48u);
    EXPECT_GT((c[7] - c[0]).cross(c[40] - c[0]), 0);
    EXPECT_GT(board_pose(c, board, scene.camera).linear()(2, 2), 0.5);
  }
}

TEST(FindBoard, PoseIsTheCamerasOwn) {
  const Board board{8, 6, 0.022};
  const Scene scene;
  const Photograph p = photograph(board, 33);
  const Eigen::Isometry3d T = board_pose(p.corners_px, board, scene.camera);
  EXPECT_LT((T.matrix() - scene.T_camera_board(33).matrix()).norm(), 1e-4);
}

TEST(FindBoard, HalfABoardIsNone) {
  const Board board{8, 6, 0.022};
  Photograph p = photograph(board, 0);
  const cv::Point2f middle = (p.corners_px[3] + p.corners_px[44]) / 2;
  p.grey.colRange(static_cast<int>(middle.x), 640).setTo(110);
  EXPECT_TRUE(find_board(p.grey, board, BoardSearch::quick).empty());
}

TEST(FindBoard, WrongCountsAreNoneAndTheRightOnesAreNamed) {
  const Photograph p = photograph(Board{8, 6, 0.022}, 0);
  for (const Board& wrong : {Board{9, 7, 0.022}, Board{9, 6, 0.022}, Board{7, 7, 0.022}})
    EXPECT_TRUE(find_board(p.grey, wrong, BoardSearch::quick).empty())
        << wrong.columns << "x" << wrong.rows;
  const auto named = find_any_board(p.grey);
  ASSERT_TRUE(named);
  EXPECT_EQ(std::max(named->width, named->height), 8);
  EXPECT_EQ(std::min(named->width, named->height), 6);
  EXPECT_FALSE(find_any_board(cv::Mat(480, 640, CV_8U, cv::Scalar(90))));
}

TEST(EdgeWidth, GrowsWithBlur) {
  const Board board{8, 6, 0.022};
  const Photograph sharp = photograph(board, 0, 0.7), soft = photograph(board, 0, 2.5);
  const double a = edge_width_px(sharp.grey, board, sharp.corners_px);
  const double b = edge_width_px(soft.grey, board, soft.corners_px);
  EXPECT_GT(a, 1.2);
  EXPECT_LT(a, 3.2);
  EXPECT_GT(b, 5.0);
}

TEST(ParseGrid, TakesTwoNumbersOnly) {
  EXPECT_EQ(parse_grid("8x6"), cv::Size(8, 6));
  EXPECT_EQ(parse_grid("11x8"), cv::Size(11, 8));
  for (const char* wrong : {"", "8", "8x", "x6", "8x6x4", "8 by 6", "2x6", "8x99", "-8x6", "8x6 "})
    EXPECT_FALSE(parse_grid(wrong)) << wrong;
}

TEST(BoardSheet, PictureIsFoundAsTheBoardItShows) {
  for (const Board& board : {Board{8, 6, 0.025}, Board{9, 6, 0.025}, Board{5, 4, 0.03}}) {
    const auto c = find_board(board_image(board, 40), board);
    ASSERT_EQ(c.size(), static_cast<std::size_t>(board.columns * board.rows));
    EXPECT_NEAR(cv::norm(c[board.columns - 1] - c[0]), 40 * (board.columns - 1), 0.2);
  }
  EXPECT_THROW(board_image(Board{50, 50, 0.02}, 1000), CalibrationError);
}

TEST(CalibrationSession, RefusesPicturesOfAnotherSize) {
  CalibrationSession session(Board{8, 6, 0.025}, {640, 480});
  const cv::Mat bgr(480, 640, CV_8UC3, cv::Scalar(90, 90, 90));
  EXPECT_FALSE(session.add(bgr, {}, {}).board_seen());
  EXPECT_THROW(session.add(bgr.rowRange(0, 240), {}, {}), CalibrationError);
}

TEST(BoardSheet, PdfHasTrueSizeOnA4) {
  const std::string pdf = board_pdf(Board{8, 6, 0.025});
  EXPECT_EQ(pdf.substr(0, 5), "%PDF-");
  EXPECT_NE(pdf.find("/MediaBox [0 0 841.8898 595.2756]"), std::string::npos);
  // 2.83465 points are a millimetre, so squares are 25 units wide.
  EXPECT_NE(pdf.find("2.83464567 0 0 2.83464567 0 0 cm"), std::string::npos);
  const std::regex square("25\\.0000 25\\.0000 re");
  EXPECT_EQ(std::distance(std::sregex_iterator(pdf.begin(), pdf.end(), square), {}), 32)
      << "black ones of 9x7";
  // The cross-reference table points at its objects.
  const std::size_t start = std::stoul(pdf.substr(pdf.rfind("startxref") + 10));
  EXPECT_EQ(pdf.substr(start, 4), "xref");
  const std::size_t first = std::stoul(pdf.substr(start + 9 + 20, 10));
  EXPECT_EQ(pdf.substr(first, 7), "1 0 obj");
}

TEST(BoardSheet, PdfIsTheSameInEveryLocale) {
  const std::string pdf = board_pdf(Board{8, 6, 0.0255});
  for (const char* locale : {"de_DE.UTF-8", "fr_FR.UTF-8", "de_DE"}) {
    if (std::setlocale(LC_ALL, locale) == nullptr) continue;
    EXPECT_EQ(board_pdf(Board{8, 6, 0.0255}), pdf);
  }
  std::setlocale(LC_ALL, "C");
  EXPECT_NE(pdf.find("--board 8x6 --square-mm 25.5. Print at 100 %; check: 9 squares are 229.5 mm"),
            std::string::npos);
}

TEST(BoardSheet, LargeBoardsGetAPageThatHoldsThem) {
  EXPECT_NE(board_pdf(Board{8, 6, 0.035}).find("/MediaBox [0 0 1190.5512 841.8898]"),
            std::string::npos);
  EXPECT_NE(board_pdf(Board{8, 6, 0.100}).find("/MediaBox [0 0 2607.8740 2040.9449]"),
            std::string::npos);
}

}  // namespace
}  // namespace handyar
