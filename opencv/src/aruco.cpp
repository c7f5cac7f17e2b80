// SPDX-License-Identifier: MIT
#include "handyar/opencv/aruco.hpp"

#include <opencv2/aruco.hpp>
#include <utility>

namespace handyar {
namespace {

constexpr std::pair<std::string_view, int> kDictionaries[] = {
    {"DICT_4X4_50", cv::aruco::DICT_4X4_50},
    {"DICT_4X4_100", cv::aruco::DICT_4X4_100},
    {"DICT_4X4_250", cv::aruco::DICT_4X4_250},
    {"DICT_4X4_1000", cv::aruco::DICT_4X4_1000},
    {"DICT_5X5_50", cv::aruco::DICT_5X5_50},
    {"DICT_5X5_100", cv::aruco::DICT_5X5_100},
    {"DICT_5X5_250", cv::aruco::DICT_5X5_250},
    {"DICT_5X5_1000", cv::aruco::DICT_5X5_1000},
    {"DICT_6X6_50", cv::aruco::DICT_6X6_50},
    {"DICT_6X6_100", cv::aruco::DICT_6X6_100},
    {"DICT_6X6_250", cv::aruco::DICT_6X6_250},
    {"DICT_6X6_1000", cv::aruco::DICT_6X6_1000},
    {"DICT_7X7_50", cv::aruco::DICT_7X7_50},
    {"DICT_7X7_100", cv::aruco::DICT_7X7_100},
    {"DICT_7X7_250", cv::aruco::DICT_7X7_250},
    {"DICT_7X7_1000", cv::aruco::DICT_7X7_1000},
    {"DICT_ARUCO_ORIGINAL", cv::aruco::DICT_ARUCO_ORIGINAL},
    {"DICT_APRILTAG_16h5", cv::aruco::DICT_APRILTAG_16h5},
    {"DICT_APRILTAG_25h9", cv::aruco::DICT_APRILTAG_25h9},
    {"DICT_APRILTAG_36h10", cv::aruco::DICT_APRILTAG_36h10},
    {"DICT_APRILTAG_36h11", cv::aruco::DICT_APRILTAG_36h11},
};

}  // namespace

std::optional<int> dictionary_number(std::string_view name) {
  for (const auto& [known, number] : kDictionaries)
    if (known == name) return number;
  return std::nullopt;
}

std::vector<std::string> dictionary_names() {
  std::vector<std::string> names;
  for (const auto& [name, number] : kDictionaries) names.emplace_back(name);
  return names;
}

// With OpenCV 4.7 a dictionary became a value, and detection an object's.
int dictionary_size(int dictionary_number) {
  const auto dictionary = cv::aruco::getPredefinedDictionary(dictionary_number);
#if CV_VERSION_MAJOR > 4 || CV_VERSION_MINOR >= 7
  return dictionary.bytesList.rows;
#else
  return dictionary->bytesList.rows;
#endif
}

std::array<cv::Point3d, 4> marker_corners_m(double size_m) {
  const double h = size_m / 2;
  return {{{-h, h, 0}, {h, h, 0}, {h, -h, 0}, {-h, -h, 0}}};
}

std::vector<SeenMarker> detect_markers(const cv::Mat& picture, int dictionary_number) {
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
  std::vector<SeenMarker> seen;
  for (std::size_t i = 0; i < ids.size(); ++i) seen.push_back({ids[i], std::move(corners[i])});
  return seen;
}

}  // namespace handyar
