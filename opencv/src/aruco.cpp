// SPDX-License-Identifier: MIT
#include "handyar/opencv/aruco.hpp"

#include <algorithm>
#include <utility>

#include "handyar/io/error.hpp"
#ifdef HANDYAR_ARUCO
#include <opencv2/aruco.hpp>
#endif

namespace handyar {
namespace {

struct Dictionary {
  std::string_view name;
  int size;
};

// In OpenCV's order, so that a dictionary's place is OpenCV's number.
constexpr Dictionary kDictionaries[] = {
    {"DICT_4X4_50", 50},        {"DICT_4X4_100", 100},         {"DICT_4X4_250", 250},
    {"DICT_4X4_1000", 1000},    {"DICT_5X5_50", 50},           {"DICT_5X5_100", 100},
    {"DICT_5X5_250", 250},      {"DICT_5X5_1000", 1000},       {"DICT_6X6_50", 50},
    {"DICT_6X6_100", 100},      {"DICT_6X6_250", 250},         {"DICT_6X6_1000", 1000},
    {"DICT_7X7_50", 50},        {"DICT_7X7_100", 100},         {"DICT_7X7_250", 250},
    {"DICT_7X7_1000", 1000},    {"DICT_ARUCO_ORIGINAL", 1024}, {"DICT_APRILTAG_16h5", 30},
    {"DICT_APRILTAG_25h9", 35}, {"DICT_APRILTAG_36h10", 2320}, {"DICT_APRILTAG_36h11", 587},
};
#ifdef HANDYAR_ARUCO
static_assert(cv::aruco::DICT_APRILTAG_36h11 + 1 == std::size(kDictionaries));
#endif

}  // namespace

std::optional<int> dictionary_number(std::string_view name) {
  const auto* const found = std::find_if(std::begin(kDictionaries), std::end(kDictionaries),
                                         [&](const Dictionary& d) { return d.name == name; });
  if (found == std::end(kDictionaries)) return std::nullopt;
  return static_cast<int>(found - kDictionaries);
}

int dictionary_size(int dictionary_number) { return kDictionaries[dictionary_number].size; }

std::vector<std::string> dictionary_names() {
  std::vector<std::string> names;
  for (const Dictionary& d : kDictionaries) names.emplace_back(d.name);
  return names;
}

std::array<cv::Point3d, 4> marker_corners_m(double size_m) {
  const double h = size_m / 2;
  return {{{-h, h, 0}, {h, h, 0}, {h, -h, 0}, {-h, -h, 0}}};
}

#ifdef HANDYAR_ARUCO

void require_aruco() {}

// With OpenCV 4.7 a dictionary became a value, and detection an object's.
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

#else

void require_aruco() {
  throw io::Error("markers", "this handyar was built without OpenCV's ArUco, which finds them");
}

std::vector<SeenMarker> detect_markers(const cv::Mat&, int) {
  require_aruco();
  return {};
}

#endif

}  // namespace handyar
