// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "handyar/calibration/still_points.hpp"
#include "handyar/camera.hpp"

namespace handyar {

/// Points of a rigid body and its poses in several views, adjusted together.
struct Bundle {
  Eigen::Matrix3Xd p_m;  ///< points in the body's frame
  std::vector<Eigen::Isometry3d> T_camera_body;
  std::vector<PixelTrack> tracks;  ///< pixel of each point in each view, or not finite

  /// Prior of the points: means and standard deviations (metres). It also fixes frame and scale.
  Eigen::Matrix3Xd prior_m, prior_sigma_m;

  Eigen::MatrixXd covariance_m2;  ///< of all points (3n x 3n), by adjust()
  double sigma_px = 1;            ///< robust spread of an error's components, by adjust()

  /// Robust Levenberg-Marquardt over points and poses.
  void adjust(const Camera& camera);

  /// Robust cost of view i for a pose.
  double view_cost(std::size_t i, const Eigen::Isometry3d& T_camera_body,
                   const Camera& camera) const;
};

}  // namespace handyar
