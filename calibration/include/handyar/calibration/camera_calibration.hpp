// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

#include "handyar/calibration/error.hpp"
#include "handyar/calibration/view.hpp"

namespace handyar {

/// Edges wider than this, for a picture 640 pixels wide, make a view useless; in proportion for
/// other widths.
inline constexpr double kMaxBlurPx = 5.0;
inline constexpr int kMinViews = 10;  ///< with fewer a camera or a hand is not determined
inline constexpr int kMaxViews = 40;  ///< more views of one recording add time, not knowledge

struct CameraCalibration {
  Camera camera;
  double rms_px = 0;            ///< reprojection error over the views used
  double focal_sigma_px = 0;    ///< standard deviation of the focal length
  double centre_sigma_px = 0;   ///< standard deviation of the principal point (the worse axis)
  std::string distortion;       ///< the terms that the footage supports: "none", "k1", ...
  std::vector<int> views_used;  ///< indices into the views given
};

/// Intrinsics and distortion of the camera (Zhang's method; paper 2.4) from the views that show the
/// board, of which the sharp ones that differ most are used. The distortion has only the terms that
/// the footage supports (Bayesian information criterion). Throws CalibrationError when the
/// recording cannot carry a calibration.
CameraCalibration calibrate_camera(std::span<const CalibrationView> views, const Board& board,
                                   cv::Size image_size);

}  // namespace handyar
