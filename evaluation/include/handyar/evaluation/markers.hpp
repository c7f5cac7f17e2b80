// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "handyar/calibration/board.hpp"
#include "handyar/camera.hpp"

namespace handyar::evaluation {

/// The family that make_apriltag_finder looks for, by OpenCV's name.
inline constexpr const char* kAprilTagDictionary = "DICT_APRILTAG_36h11";

/// A printed square marker. Marker frame: origin at the centre, x right, y up, z out of the print.
struct Marker {
  std::string dictionary;   ///< OpenCV's name, e.g. "DICT_4X4_50", "DICT_APRILTAG_36h11"
  int id = -1;              ///< -1: whichever of the dictionary is seen most often
  double size_m = 0.08;     ///< outer side of the black square
  bool size_known = false;  ///< by truth; else a metre of its pose is a guess

  bool is_apriltag() const { return dictionary.starts_with("DICT_APRILTAG"); }
  bool is_or_may_be(int seen_id) const { return id < 0 || id == seen_id; }
};

/// A board found in a frame.
struct BoardView {
  std::vector<Eigen::Vector2d> corners_px;  ///< in the order of Board::corners_m
  Eigen::Isometry3d T_camera_board = Eigen::Isometry3d::Identity();
};

/// Finds a board frame by frame. Most boards look the same after some turns: of these poses the one
/// nearest to the last is taken, so that the board keeps its first corner.
class BoardFinder {
 public:
  BoardFinder(const Board& board, const Camera& camera);
  /// Empty when the board is not seen whole in the picture, grey or BGR.
  std::optional<BoardView> find(const cv::Mat& picture);

 private:
  Board board_;
  Camera camera_;
  std::optional<Eigen::Isometry3d> last_;  ///< T_camera_board
};

/// A marker found in a frame.
struct MarkerView {
  int id;
  Eigen::Isometry3d T_camera_marker;
};

/// A marker system used as the yardstick: detection and pose, one thread.
class MarkerFinder {
 public:
  virtual ~MarkerFinder() = default;
  /// The markers that are looked for, the largest in the picture first.
  virtual std::vector<MarkerView> find(const cv::Mat& gray, const Camera& camera) = 0;
};

/// Poses of one marker, frame by frame: of several in view the one that is seen in most frames.
std::vector<std::optional<Eigen::Isometry3d>> follow_one(
    std::span<const std::vector<MarkerView>> frames);

/// Names of the dictionaries of ArUco (AprilTag has a finder of its own).
std::vector<std::string> aruco_dictionaries();

/// OpenCV's ArUco with corners refined to sub-pixel and the square's own closed-form pose.
/// Throws std::invalid_argument when OpenCV knows no such dictionary.
std::unique_ptr<MarkerFinder> make_aruco_finder(const Marker& marker);

/// AprilTag 3 (family 36h11) with its own pose estimate.
std::unique_ptr<MarkerFinder> make_apriltag_finder(const Marker& marker);

/// Version of OpenCV that the baselines run with.
std::string opencv_version();

}  // namespace handyar::evaluation
