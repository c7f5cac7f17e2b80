// SPDX-License-Identifier: MIT
#include "handyar/io/camera_file.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "handyar/io/error.hpp"
#include "handyar/io/pending_file.hpp"
#include "sources.hpp"

namespace handyar::io {
namespace {

constexpr int kMaxSide_px = 65536;
constexpr double kLongestReadout_s = 0.1;
constexpr int kMaxBegun = 5000;  // values that may hold others; four times as many fit the stack
constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf", kFirstLines = "%YAML:1.0\n---\n";

// After the end of a document OpenCV 4.6 never returns from a line that begins with a dash. So all
// is to be one document: keys are not indented, and no line begins with a dash but "---".
bool has_stray_line(std::string_view yaml) {
  bool first_key = true;
  while (!yaml.empty()) {
    const std::string_view line = yaml.substr(0, yaml.find('\n'));
    yaml.remove_prefix(std::min(yaml.size(), line.size() + 1));
    const auto start = line.find_first_not_of(" \t\r");
    if (start == std::string_view::npos || line[start] == '#') continue;
    if (line[0] == '-' && line.substr(0, line.find_last_not_of(" \r") + 1) != "---") return true;
    if (line[0] == '-' || line[0] == '%') continue;
    if (first_key && start > 0) return true;
    first_key = false;
  }
  return false;
}

// OpenCV calls itself for each value within another, as deep as they go. How deep that is need not
// be known when there are few altogether: brackets, tags, keys and dashes before no number.
bool nests_too_deep(std::string_view text) {
  int begun = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char next = i + 1 < text.size() ? text[i + 1] : ' ';
    const bool item = text[i] == '-' && next != '.' && (next < '0' || next > '9');
    begun += item || std::string_view("[{<:").find(text[i]) != std::string_view::npos;
  }
  return begun > kMaxBegun;
}

// OpenCV's fault is "(LINE): WHAT" behind other things; 4.6 gives it for the function's name.
std::string line_and_fault(const cv::Exception& e, int lines_before) {
  for (const std::string& text : {e.err, e.func}) {
    const auto end = text.rfind("): ");
    const auto begin = text.rfind('(', end);
    if (end == std::string::npos || begin == std::string::npos) continue;
    const int line = std::atoi(text.c_str() + begin + 1) - lines_before;
    if (line > 0) return ": line " + std::to_string(line) + ": " + text.substr(end + 3);
  }
  return "";
}

// A camera file being read: each getter checks what it gives.
class YamlReader {
 public:
  YamlReader(std::string_view text, std::string_view name) : name_(name) {
    silence_libraries();
    if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
    std::string yaml(text);
    if (yaml.find('\0') != std::string::npos) fail("is not a camera file (YAML)");
    if (nests_too_deep(yaml) || has_stray_line(yaml)) fail("is not a camera file (YAML)");
    // OpenCV insists on its own first line, ROS does not write it.
    const bool complete =
        yaml.starts_with("%YAML") || yaml.starts_with("{") || yaml.starts_with("<?xml");
    if (!complete) yaml.insert(0, kFirstLines);
    try {
      storage_.open(yaml, cv::FileStorage::READ | cv::FileStorage::MEMORY);
    } catch (const cv::Exception& e) {
      fail("is not a camera file (YAML)" + line_and_fault(e, complete ? 0 : 2));
    } catch (const std::exception&) {  // its parser lets std::length_error and the like through
      fail("is not a camera file (YAML)");
    }
    if (!storage_.isOpened() || !storage_.root().isMap()) fail("is not a camera file (YAML)");
  }

  [[noreturn]] void fail(const std::string& fault) const { throw Error(name_, fault); }

  cv::FileNode field(const char* key) const {
    cv::FileNode node = storage_[key];
    if (node.empty()) fail(std::string(key) + " is missing");
    return node;
  }

  int size(const char* key) const {
    const cv::FileNode node = field(key);
    const int value = node.isInt() ? static_cast<int>(node) : 0;
    if (value < 1 || value > kMaxSide_px) {
      fail(std::string(key) + " must be a whole number from 1 to " + std::to_string(kMaxSide_px));
    }
    return value;
  }

  // The numbers of an OpenCV matrix, or of a ROS map with the same entries.
  std::vector<double> matrix(const char* key, int& rows, int& cols) const {
    const cv::FileNode node = field(key);
    if (!node.isMap() || !node["data"].isSeq() || !node["rows"].isInt() || !node["cols"].isInt()) {
      fail(std::string(key) + " is not a matrix (rows, cols, data)");
    }
    rows = static_cast<int>(node["rows"]);
    cols = static_cast<int>(node["cols"]);
    std::vector<double> values;
    for (const cv::FileNode& element : node["data"]) {
      const std::string which = std::string(key) + ": number " + std::to_string(values.size() + 1);
      if (!element.isInt() && !element.isReal()) fail(which + " is not a number");
      values.push_back(static_cast<double>(element));
      if (!std::isfinite(values.back())) fail(which + " is not finite");
    }
    if (rows < 1 || cols < 1 || rows > 64 || cols > 64 ||
        values.size() != static_cast<std::size_t>(rows) * static_cast<std::size_t>(cols)) {
      fail(std::string(key) + ": rows, cols and the count of its numbers disagree");
    }
    return values;
  }

  // 0 where there is none.
  double seconds(const char* key, double most) const {
    const cv::FileNode node = storage_[key];
    if (node.empty()) return 0;
    const double value = node.isInt() || node.isReal() ? static_cast<double>(node) : -1;
    if (!(value >= 0 && value <= most))
      fail(std::string(key) + " must be a number from 0 to " + std::to_string(most).substr(0, 3));
    return value;
  }

  // False where there is none.
  bool flag(const char* key) const {
    const cv::FileNode node = storage_[key];
    if (node.empty()) return false;
    const int value = node.isInt() ? static_cast<int>(node) : -1;
    if (value != 0 && value != 1) fail(std::string(key) + " must be 0 or 1");
    return value == 1;
  }

  std::string text(const char* key) const {
    const cv::FileNode node = storage_[key];
    return node.isString() ? static_cast<std::string>(node) : std::string();
  }

 private:
  std::string name_;
  cv::FileStorage storage_;
};

void read_intrinsics(const YamlReader& file, Camera& camera) {
  int rows = 0, cols = 0;
  const std::vector<double> K = file.matrix("camera_matrix", rows, cols);
  if (rows != 3 || cols != 3) file.fail("camera_matrix is not 3x3");
  camera.fx_px = K[0];
  camera.cx_px = K[2];
  camera.fy_px = K[4];
  camera.cy_px = K[5];
  // A field of view between 3 degrees and 170: anything else is a slip of units or columns.
  const double side_px = std::max(camera.width_px, camera.height_px);
  for (const double f_px : {camera.fx_px, camera.fy_px}) {
    if (f_px <= 0) file.fail("camera_matrix: a focal length is not positive");
    if (f_px < 0.04 * side_px || f_px > 20 * side_px) {
      file.fail("camera_matrix: a focal length does not fit the picture's size");
    }
  }
  if (camera.cx_px < 0 || camera.cx_px > camera.width_px || camera.cy_px < 0 ||
      camera.cy_px > camera.height_px) {
    file.fail("camera_matrix: the principal point is outside the picture");
  }
  if (K[1] != 0 || K[3] != 0 || K[6] != 0 || K[7] != 0 || K[8] != 1) {
    file.fail("camera_matrix is not of the form fx 0 cx, 0 fy cy, 0 0 1");
  }
}

void read_distortion(const YamlReader& file, Camera& camera) {
  const std::string model = file.text("distortion_model");
  if (!model.empty() && model != "plumb_bob" && model != "rational_polynomial") {
    file.fail("distortion_model " + model + " is not supported, only plumb_bob");
  }
  int rows = 0, cols = 0;
  const std::vector<double> d = file.matrix("distortion_coefficients", rows, cols);
  if ((rows != 1 && cols != 1) || (d.size() != 4 && d.size() != 5 && d.size() != 8)) {
    file.fail("distortion_coefficients: 4, 5 or 8 numbers are expected, not " +
              std::to_string(d.size()));
  }
  for (std::size_t i = 0; i < d.size(); ++i) {
    if (i >= camera.distortion.size()) {
      if (d[i] != 0) file.fail("distortion_coefficients: k4, k5, k6 are not supported, only zero");
      continue;
    }
    if (std::abs(d[i]) > 100) {
      file.fail("distortion_coefficients: number " + std::to_string(i + 1) + " is beyond reason");
    }
    camera.distortion[i] = d[i];
  }
}

// Outwards from the centre a lens shows one direction after the other, in the same turn:
// coefficients that fold the picture are a slip. Its corners may fold, no calibration looks there.
void require_unfolded(const YamlReader& file, const Camera& camera) {
  constexpr double kWithin = 0.75, kStep = 0.02, kFarthest = 12;  // tan of 85 degrees
  constexpr int kDirections = 24;
  const auto within = [&](const Eigen::Vector2d& px) {
    const double x = (px.x() - camera.cx_px) / camera.width_px;
    const double y = (px.y() - camera.cy_px) / camera.height_px;
    return std::hypot(x, y) < 0.5 * kWithin;
  };
  for (int i = 0; i < kDirections; ++i) {
    const double angle_rad = 2 * std::numbers::pi * i / kDirections;
    const Eigen::Vector3d direction(std::cos(angle_rad), std::sin(angle_rad), 0);
    Eigen::Vector2d px = camera.project(Eigen::Vector3d::UnitZ());
    for (double r = kStep; within(px); r += kStep) {
      Eigen::Matrix<double, 2, 3> J;
      px = camera.project(r * direction + Eigen::Vector3d::UnitZ(), &J);
      const double turn = J.leftCols<2>().determinant();
      if (!(turn > 0) || r > kFarthest)
        file.fail("distortion_coefficients fold the picture over itself");
    }
  }
}

void append(std::string& text, double value) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
  const std::string_view number(digits, static_cast<std::size_t>(end - digits));
  text += number;
  if (number.find_first_of(".e") == std::string_view::npos) text += '.';  // a real to OpenCV
}

}  // namespace

Camera parse_camera(std::string_view text, std::string_view name) {
  try {
    const YamlReader file(text, name);
    Camera camera;
    camera.width_px = file.size("image_width");
    camera.height_px = file.size("image_height");
    read_intrinsics(file, camera);
    read_distortion(file, camera);
    require_unfolded(file, camera);
    camera.readout_s = file.seconds("readout_s", kLongestReadout_s);
    camera.assumed = file.flag("assumed");
    return camera;
  } catch (const cv::Exception&) {
    throw Error(name, "is not a camera file (YAML)");
  }
}

Camera read_camera(const std::string& path) { return parse_camera(read_text(path), path); }

void write_camera(const std::string& path, const Camera& camera) {
  std::string text =
      "%YAML:1.0\n---\nimage_width: " + std::to_string(camera.width_px) +
      "\nimage_height: " + std::to_string(camera.height_px) +
      "\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ ";
  const double K[] = {camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1};
  for (int i = 0; i < 9; ++i) append(text += i == 0 ? "" : ", ", K[i]);
  text +=
      " ]\ndistortion_coefficients: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n   data: [ ";
  for (std::size_t i = 0; i < 5; ++i) append(text += i == 0 ? "" : ", ", camera.distortion[i]);
  text += " ]\n";
  if (camera.readout_s > 0) {
    append(text += "readout_s: ", camera.readout_s);
    text += '\n';
  }
  if (camera.assumed) text += "assumed: 1\n";
  write_text(path, text);
}

Camera camera_for_size(const Camera& camera, int width_px, int height_px, const std::string& path) {
  const double scale_x = static_cast<double>(width_px) / camera.width_px;
  const double height_expected_px = camera.height_px * scale_x;
  if (!camera.assumed && std::abs(height_expected_px - height_px) > 1.0) {
    throw Error(path, "is for pictures of " + std::to_string(camera.width_px) + "x" +
                          std::to_string(camera.height_px) + " pixels, the input has " +
                          std::to_string(width_px) + "x" + std::to_string(height_px) +
                          ": another shape, so it cannot be scaled to it");
  }
  return camera.scaled_to(width_px, height_px);
}

}  // namespace handyar::io
