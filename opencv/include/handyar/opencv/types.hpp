// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <opencv2/core/affine.hpp>
#include <opencv2/core/eigen.hpp>

#include "handyar/camera.hpp"

namespace handyar {

inline cv::Matx33d camera_matrix(const Camera& c) {
  return {c.fx_px, 0, c.cx_px, 0, c.fy_px, c.cy_px, 0, 0, 1};
}

inline Eigen::Isometry3d isometry(const cv::Vec3d& rotation, const cv::Vec3d& translation) {
  Eigen::Isometry3d T;
  cv::cv2eigen(cv::Affine3d(rotation, translation).matrix, T.matrix());
  return T;
}

}  // namespace handyar
