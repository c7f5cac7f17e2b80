// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "handyar/camera.hpp"

namespace handyar {

/// A checkerboard, named by its inner corners (a board of 9x7 squares has 8x6).
///
/// Board frame: origin at the first inner corner, x along a row of `columns` corners, y along the
/// columns, z into the board, away from who looks at it.
struct Board {
  int columns = 8;          ///< inner corners in a row
  int rows = 6;             ///< rows of inner corners
  double square_m = 0.025;  ///< side of a square

  /// Inner corners in the board frame, row by row (metres, z = 0).
  std::vector<cv::Point3f> corners_m() const;
  /// Middle of the inner corners in the board frame (metres).
  Eigen::Vector3d centre_m() const;
  /// The turns about its centre after which the board is found as before, none first: half a turn
  /// where both corner counts are even or both odd, quarter turns where they are the same.
  std::vector<Eigen::Isometry3d> turns() const;
};

/// "8x6" as columns and rows, each from 3 to 50; empty when the text says something else.
std::optional<cv::Size> parse_grid(const std::string& text);

/// How hard to look for a board: `quick` takes some 10 ms of a 640x480 frame whether there is one
/// or not; `thorough` also copes with strong shadows, but takes a quarter of a second to find none.
enum class BoardSearch : std::uint8_t { quick, thorough };

/// Inner corners in a grey or BGR picture, row by row as in Board::corners_m(), sub-pixel; empty
/// when the whole board is not in view. Which corner is the first is arbitrary, up to the board's
/// turns().
std::vector<cv::Point2f> find_board(const cv::Mat& image, const Board& board,
                                    BoardSearch search = BoardSearch::thorough);

/// Width in pixels over which the squares' edges rise from 10 % to 90 %: about 2 for a sharp
/// picture, more when it is blurred by motion or out of focus.
double edge_width_px(const cv::Mat& image, const Board& board,
                     const std::vector<cv::Point2f>& corners_px);

/// The number of inner corners of whatever checkerboard is in view, the larger first, for an advice
/// when the wanted one is not found (some 50 ms).
std::optional<cv::Size> find_any_board(const cv::Mat& image);

/// Pose of the board from its corners (paper 2.4), least squares over all of them.
Eigen::Isometry3d board_pose(const std::vector<cv::Point2f>& corners_px, const Board& board,
                             const Camera& camera);

}  // namespace handyar
