// SPDX-License-Identifier: MIT
// All that needs OpenCV's ArUco, as a library of its own that is loaded when markers are looked
// for.
#include "markers_module.hpp"

#include <opencv2/aruco.hpp>
#include <utility>

#include "handyar/api.h"

static_assert(cv::aruco::DICT_APRILTAG_36h11 + 1 == handyar::kDictionaryCount);

// With OpenCV 4.7 a dictionary became a value, and detection an object's.
extern "C" HANDYAR_API void handyar_find_markers(const cv::Mat& picture, int dictionary_number,
                                                 std::vector<handyar::SeenMarker>& seen) {
  const auto dictionary = cv::aruco::getPredefinedDictionary(dictionary_number);
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
#if CV_VERSION_MAJOR > 4 || CV_VERSION_MINOR >= 7
  cv::aruco::DetectorParameters parameters;
  parameters.cornerRefinementMethod = cv::aruco::CORNER_REFINE_SUBPIX;
  cv::aruco::ArucoDetector(dictionary, parameters).detectMarkers(picture, corners, ids);
#else
  const auto parameters = cv::aruco::DetectorParameters::create();
  parameters->cornerRefinementMethod = cv::aruco::CORNER_REFINE_SUBPIX;
  cv::aruco::detectMarkers(picture, dictionary, corners, ids, parameters);
#endif
  for (std::size_t i = 0; i < ids.size(); ++i) seen.push_back({ids[i], std::move(corners[i])});
}
