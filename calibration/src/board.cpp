// SPDX-License-Identifier: MIT
#include "handyar/calibration/board.hpp"

#include <cstdio>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "handyar/opencv/types.hpp"

namespace handyar {
namespace {

cv::Mat grey(const cv::Mat& image) {
  if (image.channels() == 1) return image;
  cv::Mat out;
  cv::cvtColor(image, out, cv::COLOR_BGR2GRAY);
  return out;
}

}  // namespace

std::vector<cv::Point3f> Board::corners_m() const {
  std::vector<cv::Point3f> out;
  out.reserve(static_cast<std::size_t>(columns) * rows);
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i)
      out.emplace_back(static_cast<float>(i * square_m), static_cast<float>(j * square_m), 0.f);
  return out;
}

Eigen::Vector3d Board::centre_m() const {
  return {(columns - 1) * square_m / 2, (rows - 1) * square_m / 2, 0};
}

std::vector<Eigen::Isometry3d> Board::turns() const {
  const int step = columns == rows ? 1 : (columns - rows) % 2 == 0 ? 2 : 4;  // quarter turns
  std::vector<Eigen::Isometry3d> all;
  for (int quarters = 0; quarters < 4; quarters += step) {
    const Eigen::AngleAxisd turn(quarters * CV_PI / 2, Eigen::Vector3d::UnitZ());
    all.emplace_back(Eigen::Translation3d(centre_m()) * turn * Eigen::Translation3d(-centre_m()));
  }
  return all;
}

std::optional<cv::Size> parse_grid(const std::string& text) {
  int columns = 0, rows = 0, used = 0;
  if (std::sscanf(text.c_str(), "%2dx%2d%n", &columns, &rows, &used) != 2) return {};
  if (static_cast<std::size_t>(used) != text.size()) return {};
  if (columns < 3 || columns > 50 || rows < 3 || rows > 50) return {};
  return cv::Size(columns, rows);
}

std::vector<cv::Point2f> find_board(const cv::Mat& image, const Board& board, BoardSearch search) {
  const cv::Mat g = grey(image);
  std::vector<cv::Point2f> c;
  // Not findChessboardCornersSB: sixteen times slower, and its corners lean by up to a quarter of a
  // pixel on small squares, which alone moves the focal length by 1.5 %.
  int flags = cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK;
  if (search == BoardSearch::thorough) flags |= cv::CALIB_CB_ADAPTIVE_THRESH;
  if (!cv::findChessboardCorners(g, {board.columns, board.rows}, c, flags)) return {};
  double nearest_px = 1e9;
  for (int j = 0; j < board.rows; ++j)
    for (int i = 0; i + 1 < board.columns; ++i) {
      const int k = j * board.columns + i;
      nearest_px = std::min(nearest_px, cv::norm(c[k + 1] - c[k]));
    }
  // The window must not reach a neighbouring corner.
  const int half = std::clamp(static_cast<int>(0.4 * nearest_px), 2, 6);
  cv::cornerSubPix(g, c, {half, half}, {-1, -1},
                   {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 40, 0.001});
  // Looked at from its front the board frame is right-handed with z away from the viewer.
  const cv::Point2f x = c[board.columns - 1] - c[0];
  const cv::Point2f y = c[c.size() - board.columns] - c[0];
  if (x.cross(y) < 0)
    for (int j = 0; j < board.rows; ++j)
      std::reverse(c.begin() + j * board.columns, c.begin() + (j + 1) * board.columns);
  return c;
}

double edge_width_px(const cv::Mat& image, const Board& board,
                     const std::vector<cv::Point2f>& corners_px) {
  return cv::estimateChessboardSharpness(grey(image), {board.columns, board.rows}, corners_px)[0];
}

std::optional<cv::Size> find_any_board(const cv::Mat& image) {
  std::vector<cv::Point2f> c;
  cv::Mat meta;
  const cv::Mat g = grey(image);
  if (!cv::findChessboardCornersSB(g, {3, 3}, c, cv::CALIB_CB_LARGER, meta)) return {};
  // It may have found a part of a board only; the other detector wants all of it.
  if (find_board(g, {meta.cols, meta.rows, 1.0}, BoardSearch::quick).empty()) return {};
  return cv::Size(std::max(meta.cols, meta.rows), std::min(meta.cols, meta.rows));
}

Eigen::Isometry3d board_pose(const std::vector<cv::Point2f>& corners_px, const Board& board,
                             const Camera& camera) {
  cv::Vec3d rotation, translation;
  const auto points = board.corners_m();
  cv::solvePnP(points, corners_px, camera_matrix(camera), camera.distortion, rotation, translation,
               false, cv::SOLVEPNP_IPPE);
  cv::solvePnPRefineLM(points, corners_px, camera_matrix(camera), camera.distortion, rotation,
                       translation);
  return isometry(rotation, translation);
}

}  // namespace handyar
