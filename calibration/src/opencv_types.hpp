// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "handyar/camera.hpp"

namespace handyar {

inline cv::Matx33d camera_matrix(const Camera& c) {
  return {c.fx_px, 0, c.cx_px, 0, c.fy_px, c.cy_px, 0, 0, 1};
}

inline Eigen::Isometry3d isometry(const cv::Vec3d& rotation, const cv::Vec3d& translation) {
  cv::Matx33d R;
  cv::Rodrigues(rotation, R);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) T.linear()(i, j) = R(i, j);
    T.translation()[i] = translation[i];
  }
  return T;
}

}  // namespace handyar
