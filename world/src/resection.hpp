// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "handyar/camera.hpp"
#include "handyar/pose.hpp"
#include "handyar/world/world_map.hpp"

namespace handyar::world {

/// A camera's pose from points of the map that it sees.
struct Resection {
  Eigen::Isometry3d T_camera_world = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Zero();  ///< as in PoseEstimate
  std::vector<Observation> inliers;
  double rms_px = 0;  ///< of the inliers
};

/// Gauss-Newton with weights that fall to nothing for what lies far off, from a pose that is nearly
/// right. `seen` are points of the map and their pixels. With fewer than six there are no inliers.
Resection resect(const WorldMap& map, std::span<const Observation> seen, const Camera& camera,
                 const Eigen::Isometry3d& T_camera_world);

}  // namespace handyar::world
