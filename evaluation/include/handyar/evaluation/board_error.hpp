// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <vector>

#include "handyar/camera.hpp"
#include "handyar/evaluation/markers.hpp"

namespace handyar::evaluation {

/// Poses of a thing (the hand, a marker) one a frame, empty where there is none.
using Poses = std::vector<std::optional<Eigen::Isometry3d>>;

/// Root mean square distance (px) between two sets of pixels, taken point by point.
double rms_distance_px(std::span<const Eigen::Vector2d> a, std::span<const Eigen::Vector2d> b);

/// Pixels of the board's inner corners under a pose.
std::vector<Eigen::Vector2d> project_board(const Board& board, const Camera& camera,
                                           const Eigen::Isometry3d& T_camera_board);

/// Reprojection error at the board's inner corners (paper 3.2): how far the corners, carried by the
/// thing's pose, lie from where they are seen. One rms over the corners a frame (px), NaN where the
/// thing or the board is not seen.
///
/// The constant transform from thing to board is fitted on alternating blocks of `block_frames` and
/// judged on the blocks between, then the other way round: no frame is judged by a transform that
/// it helped to fit.
std::vector<double> board_errors_px(const Board& board, const Camera& camera,
                                    std::span<const std::optional<BoardView>> views,
                                    const Poses& T_camera_thing, int block_frames = 15);

/// The same with the thing-to-board transform and the board's pose known exactly.
std::vector<double> board_errors_px(const Board& board, const Camera& camera,
                                    std::span<const Eigen::Isometry3d> T_camera_board,
                                    const Poses& T_camera_thing,
                                    const Eigen::Isometry3d& T_thing_board);

/// What remains when the board is projected by its own pose (px rms, one a frame).
std::vector<double> own_errors_px(const Board& board, const Camera& camera,
                                  std::span<const std::optional<BoardView>> views);

}  // namespace handyar::evaluation
