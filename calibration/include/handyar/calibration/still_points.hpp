// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "handyar/camera.hpp"

namespace handyar {

/// One place of an outline (a fingertip, a valley) in several views: pixel i belongs to pose i; not
/// finite where it was not seen.
using PixelTrack = std::vector<Eigen::Vector2d>;

/// Neighbouring views err alike: one sweep of the camera over a hand is worth so many.
constexpr double kIndependentViews = 5;

struct StillPoints {
  Eigen::Matrix3Xd p_m;                        ///< in the board frame
  std::vector<Eigen::Matrix3d> covariance_m2;  ///< of each point; empty: not estimated
  Eigen::VectorXd
      error_m;        ///< two thirds of the pixels, carried to the point, are nearer than this
  double rms_px = 0;  ///< of the smaller 90 % of the reprojection errors
};

/// The paper's way (2.4): every pixel is carried to the plane at `height_m` above the board, and
/// the median over the views taken.
StillPoints on_plane(std::span<const PixelTrack> tracks,
                     std::span<const Eigen::Isometry3d> T_camera_board, const Camera& camera,
                     double height_m);

/// Robust triangulation from all views together, no height assumed.
///
/// Oblique views count less, many views count as a few independent ones, and points of a hand that
/// lies flat are held near their common height, whatever that is, with a spread of 2 mm.
StillPoints triangulate(std::span<const PixelTrack> tracks,
                        std::span<const Eigen::Isometry3d> T_camera_board, const Camera& camera);

/// Two thirds of a track's pixels, carried to the point at their depth, are nearer than this
/// (metres).
double usual_error_m(const PixelTrack& track, std::span<const Eigen::Isometry3d> T_camera_point,
                     const Camera& camera, const Eigen::Vector3d& p_m);

/// Point of the plane at `height_m` above the board that a pixel shows, in the board frame.
Eigen::Vector3d unproject_to_plane(const Eigen::Vector2d& px,
                                   const Eigen::Isometry3d& T_camera_board, const Camera& camera,
                                   double height_m);

}  // namespace handyar
