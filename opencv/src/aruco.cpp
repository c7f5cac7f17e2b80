// SPDX-License-Identifier: MIT
#include "handyar/opencv/aruco.hpp"

#include <dlfcn.h>

#include <algorithm>

#include "handyar/io/error.hpp"
#include "markers_module.hpp"

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
static_assert(std::size(kDictionaries) == kDictionaryCount);

// Null: it is not installed. Programs know its folder by their RUNPATH.
FindMarkers* loaded() {
  static FindMarkers* const found = [] {
    void* const library = ::dlopen(HANDYAR_MARKERS_LIBRARY, RTLD_NOW | RTLD_LOCAL);
    return library == nullptr ? nullptr
                              : reinterpret_cast<FindMarkers*>(::dlsym(library, kFindMarkers));
  }();
  return found;
}

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

void require_aruco() {
  if (loaded() == nullptr)
    throw io::Error("markers",
                    "OpenCV's ArUco, which finds them, is not there: install the package "
                    "handyar-markers, or build with libopencv-contrib-dev");
}

std::vector<SeenMarker> detect_markers(const cv::Mat& picture, int dictionary_number) {
  require_aruco();
  std::vector<SeenMarker> seen;
  loaded()(picture, dictionary_number, seen);
  return seen;
}

}  // namespace handyar
