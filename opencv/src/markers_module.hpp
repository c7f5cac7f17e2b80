// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "handyar/opencv/aruco.hpp"

namespace handyar {

/// What the library of markers_module.cpp gives, by this name.
using FindMarkers = void(const cv::Mat& picture, int dictionary_number,
                         std::vector<SeenMarker>& seen);
inline constexpr const char* kFindMarkers = "handyar_find_markers";

inline constexpr int kDictionaryCount = 21;  ///< that OpenCV has

}  // namespace handyar
