// SPDX-License-Identifier: MIT
#include "handyar/evaluation/board_error.hpp"

#include <cmath>
#include <limits>

#include "handyar/evaluation/rigid.hpp"

namespace handyar::evaluation {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kLeastFrames = 5;  ///< fewer do not make a transform

}  // namespace

double rms_distance_px(std::span<const Eigen::Vector2d> a, std::span<const Eigen::Vector2d> b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
  return std::sqrt(sum / double(a.size()));
}

std::vector<Eigen::Vector2d> project_board(const Board& board, const Camera& camera,
                                           const Eigen::Isometry3d& T_camera_board) {
  std::vector<Eigen::Vector2d> px;
  for (const cv::Point3f& p : board.corners_m())
    px.push_back(camera.project(T_camera_board * Eigen::Vector3d(p.x, p.y, p.z)));
  return px;
}

std::vector<double> board_errors_px(const Board& board, const Camera& camera,
                                    std::span<const std::optional<BoardView>> views,
                                    const Poses& T_camera_thing, int block_frames) {
  std::vector<double> errors(views.size(), kNone);
  for (std::size_t judged = 0; judged < 2; ++judged) {
    const auto half_of = [&](std::size_t i) { return i / std::size_t(block_frames) % 2; };
    std::vector<Eigen::Isometry3d> measured;  // of T_thing_board
    for (std::size_t i = 0; i < views.size(); ++i)
      if (half_of(i) != judged && views[i] && T_camera_thing[i])
        measured.push_back(T_camera_thing[i]->inverse() * views[i]->T_camera_board);
    if (measured.size() < kLeastFrames) continue;
    const Eigen::Isometry3d T_thing_board = robust_mean(measured);
    for (std::size_t i = 0; i < views.size(); ++i)
      if (half_of(i) == judged && views[i] && T_camera_thing[i])
        errors[i] = rms_distance_px(
            project_board(board, camera, *T_camera_thing[i] * T_thing_board), views[i]->corners_px);
  }
  return errors;
}

std::vector<double> board_errors_px(const Board& board, const Camera& camera,
                                    std::span<const Eigen::Isometry3d> T_camera_board,
                                    const Poses& T_camera_thing,
                                    const Eigen::Isometry3d& T_thing_board) {
  std::vector<double> errors(T_camera_thing.size(), kNone);
  for (std::size_t i = 0; i < std::min(errors.size(), T_camera_board.size()); ++i)
    if (T_camera_thing[i])
      errors[i] = rms_distance_px(project_board(board, camera, *T_camera_thing[i] * T_thing_board),
                                  project_board(board, camera, T_camera_board[i]));
  return errors;
}

std::vector<double> own_errors_px(const Board& board, const Camera& camera,
                                  std::span<const std::optional<BoardView>> views) {
  std::vector<double> errors(views.size(), kNone);
  for (std::size_t i = 0; i < views.size(); ++i)
    if (views[i])
      errors[i] = rms_distance_px(project_board(board, camera, views[i]->T_camera_board),
                                  views[i]->corners_px);
  return errors;
}

}  // namespace handyar::evaluation
