// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace handyar {

/// OpenCV's number of a marker dictionary, e.g. "DICT_4X4_50"; empty when it has none of that name.
std::optional<int> dictionary_number(std::string_view name);

/// How many markers it has; their ids count from 0.
int dictionary_size(int dictionary_number);

/// Names of all of them, AprilTag's ("DICT_APRILTAG_...") at the end.
std::vector<std::string> dictionary_names();

/// Corners of an upright print in its own frame (metres): top left, top right, bottom right, bottom
/// left; origin at the centre, x right, y up, z out of the print.
std::array<cv::Point3d, 4> marker_corners_m(double size_m);

struct SeenMarker {
  int id;
  std::vector<cv::Point2f> corners_px;  ///< in the order of marker_corners_m
};

/// Throws io::Error where OpenCV's ArUco is not installed: it is in OpenCV's contrib modules, which
/// are large and which only markers need, so what uses it is a library of its own.
void require_aruco();

/// The markers of a dictionary in a grey or BGR picture, corners refined to sub-pixel.
/// Throws like require_aruco.
std::vector<SeenMarker> detect_markers(const cv::Mat& picture, int dictionary_number);

}  // namespace handyar
