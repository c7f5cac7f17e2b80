// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "handyar/camera.hpp"

namespace handyar::world {

/// A corner of the surroundings, in the world frame.
struct MapPoint {
  Eigen::Vector3d p_world_m = Eigen::Vector3d::Zero();
  /// Greater than 0: it was taken to lie on the plane under the hand, with this standard deviation
  /// of its height. 0: it was triangulated.
  double plane_sigma_m = 0;
};

/// Where a keyframe shows a point of the map.
struct Observation {
  int point = 0;  ///< index in WorldMap::points
  Eigen::Vector2d px = Eigen::Vector2d::Zero();
};

/// A picture that the map keeps, to be found again in later ones.
struct Keyframe {
  cv::Mat grey;  ///< 8-bit
  Eigen::Isometry3d T_camera_world = Eigen::Isometry3d::Identity();
  bool hand_in_view = false;  ///< what lay under the hand is not in it
  std::vector<Observation> observations;

  /// Corners by which the picture is recognised, row by row with `descriptors` (ORB, 8-bit), and
  /// the point that each shows, -1 for none.
  std::vector<cv::KeyPoint> corners;
  cv::Mat descriptors;
  std::vector<int> corner_points;
};

/// The surroundings as far as they are known, in the frame that the hand has set: origin, axes and
/// scale are those of the hand frame (docs/conventions.md) at that moment.
struct WorldMap {
  Camera camera;               ///< of all keyframes
  bool scale_assumed = false;  ///< the hand was not measured: metres are an average adult's
  /// Height of the hand frame above what the hand lay on when it set the frame: z = 0 above the
  /// plane near which points with a plane_sigma_m are held.
  double hand_thickness_m = 0.005;
  /// What the hand lay on, as the points tell: normal towards the camera, in world coordinates.
  Eigen::Hyperplane<double, 3> ground{Eigen::Vector3d::UnitZ(), 0.0};
  std::vector<MapPoint> points;
  std::vector<Keyframe> keyframes;  ///< the first is the one in which the hand set the frame
};

/// Reads a map file (docs/formats.md), checks all that is in it, and makes descriptors anew; throws
/// io::Error with one line that names file and fault.
[[nodiscard]] WorldMap read_map(const std::string& path);

/// The same from bytes; `name` stands for the file in messages.
[[nodiscard]] WorldMap parse_map(std::string_view bytes, std::string_view name);

/// Writes a map that has a keyframe; the file is whole or not there. Throws io::Error.
void write_map(const std::string& path, const WorldMap& map);

}  // namespace handyar::world
