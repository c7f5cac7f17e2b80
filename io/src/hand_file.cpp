// SPDX-License-Identifier: MIT
#include "handyar/io/hand_file.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "handyar/io/error.hpp"
#include "handyar/io/json.hpp"
#include "handyar/io/pending_file.hpp"

namespace handyar::io {
namespace {

constexpr double kMinSpan_m = 0.05, kMaxSpan_m = 0.35;
constexpr double kMinGap_m = 0.005;       // between neighbouring fingertips
constexpr double kLeastTurn_m2 = 1e-6;    // from one to the next about the palm: none on a line
constexpr double kMaxCoordinate_m = 0.5;  // of anything on a hand
constexpr double kMaxHeight_m = 0.12;     // above or below the mean of the fingertips
constexpr double kMaxThickness_m = 0.1;
// A hand file has 5 kB. Keys are looked up one after the other, so many of them take long.
constexpr std::size_t kMaxBytes = 64 << 10;
constexpr double kMostCoefficient = 8;  // of a figure, in standard deviations of people

constexpr std::pair<std::string_view, HandSource> kSources[] = {
    {"checkerboard", HandSource::checkerboard},
    {"default", HandSource::average_adult},
    {"self", HandSource::self},
    {"truth", HandSource::truth}};

// A hand file being read: each getter checks what it gives.
class Reader {
 public:
  Reader(const Json& root, std::string_view name) : root_(root), name_(name) {
    if (!root.is_object()) fail("is not a hand file");
  }

  [[noreturn]] void fail(const std::string& fault) const { throw Error(name_, fault); }

  bool has(const char* key) const { return root_.contains(key); }

  const Json& field(const char* key) const {
    const auto found = root_.find(key);
    if (found == root_.end()) fail(std::string(key) + " is missing");
    return *found;
  }

  std::string text(const char* key) const {
    const Json& value = field(key);
    if (!value.is_string()) fail(std::string(key) + " is not a text");
    return value.get<std::string>();
  }

  double number(const Json& value, const std::string& what) const {
    if (!value.is_number()) fail(what + " is not a number");
    const double x = value.get<double>();
    if (!std::isfinite(x)) fail(what + " is not finite");
    return x;
  }

  double number_within(const char* key, double low, double high) const {
    const double x = number(field(key), key);
    if (x < low || x > high) fail(std::string(key) + " is beyond reason");
    return x;
  }

  // One metric vector for each name, and no others.
  template <std::size_t N>
  Eigen::Matrix<double, 3, static_cast<int>(N)> points(
      const char* key, const std::array<std::string_view, N>& names) const {
    const Json& value = field(key);
    if (!value.is_object()) fail(std::string(key) + " is not a set of named points");
    for (const auto& [name, point] : value.items()) {
      if (std::find(names.begin(), names.end(), name) == names.end()) {
        fail(std::string(key) + ": there is no " + name + " on a hand");
      }
    }
    Eigen::Matrix<double, 3, static_cast<int>(N)> points;
    for (std::size_t i = 0; i < N; ++i) {
      const std::string what = std::string(key) + ": " + std::string(names[i]);
      const auto found = value.find(names[i]);
      if (found == value.end()) fail(what + " is missing");
      if (!found->is_array() || found->size() != 3) fail(what + " is not [x, y, z]");
      for (int k = 0; k < 3; ++k) {
        const double x = number((*found)[static_cast<std::size_t>(k)], what);
        if (std::abs(x) > kMaxCoordinate_m) fail(what + " is too far off: the unit is the metre");
        points(k, static_cast<int>(i)) = x;
      }
    }
    return points;
  }

 private:
  const Json& root_;
  std::string name_;
};

void read_tips(const Reader& file, HandModel& hand) {
  hand.tips_m = file.points("tips_m", kFingerNames);
  const double mean_z_m = hand.tips_m.row(2).mean();
  for (int i = 0; i < kFingerCount; ++i) {
    const double height_m = std::abs(hand.tips_m(2, i) - mean_z_m);
    if (height_m > kMaxHeight_m)
      file.fail("tips_m: " + std::string(kFingerNames[static_cast<std::size_t>(i)]) + " is " +
                std::to_string(std::lround(height_m * 1000)) +
                " mm off the plane of the others, a finger bends by 120 mm at most");
  }
  if (hand.span_m() < kMinSpan_m || hand.span_m() > kMaxSpan_m) {
    file.fail("tips_m: thumb and little finger are " +
              std::to_string(std::lround(hand.span_m() * 1000)) +
              " mm apart, a hand has 50 to 350 mm");
  }
  for (int i = 0; i + 1 < kFingerCount; ++i) {
    if ((hand.tips_m.col(i) - hand.tips_m.col(i + 1)).norm() < kMinGap_m) {
      file.fail("tips_m: " + std::string(kFingerNames[static_cast<std::size_t>(i)]) + " and " +
                std::string(kFingerNames[static_cast<std::size_t>(i) + 1]) + " are at one place");
    }
  }
}

// Seen from the palm the fingertips follow each other one way round.
void require_order(const Reader& file, const HandModel& hand) {
  int turns = 0;
  for (int i = 0; i + 1 < kFingerCount; ++i) {
    const Eigen::Vector2d a = (hand.tips_m.col(i) - hand.palm_centre_m()).head<2>();
    const Eigen::Vector2d b = (hand.tips_m.col(i + 1) - hand.palm_centre_m()).head<2>();
    const double turn_m2 = a.x() * b.y() - a.y() * b.x();
    turns += (turn_m2 > kLeastTurn_m2) - (turn_m2 < -kLeastTurn_m2);
  }
  if (std::abs(turns) != kFingerCount - 1) {
    file.fail("tips_m: the fingers do not lie in order from thumb to little");
  }
}

void read_version_2(const Reader& file, HandModel& hand) {
  if (file.has("tips_sigma_m")) {
    hand.tips_sigma_m = file.points("tips_sigma_m", kFingerNames);
    if (hand.tips_sigma_m.minCoeff() < 0) file.fail("tips_sigma_m: a deviation is negative");
  }
  if (file.has("scale")) {
    const std::string scale = file.text("scale");
    if (scale != "measured" && scale != "average") {
      file.fail("scale is neither measured nor average");
    }
    hand.average_scale = scale == "average";
  }
}

// The person's figure: coefficients and their covariance, row by row.
void read_version_4(const Reader& file, HandModel& hand) {
  if (!file.has("figure")) return;
  const Json& figure = file.field("figure");
  if (!figure.is_object() || !figure.contains("mean") || !figure.contains("covariance"))
    file.fail("figure has no mean and covariance");
  const Json &mean = figure["mean"], &covariance = figure["covariance"];
  const std::string modes = std::to_string(kFigureModes);
  if (!mean.is_array() || mean.size() != kFigureModes)
    file.fail("figure: mean is not a list of " + modes + " numbers");
  if (!covariance.is_array() || covariance.size() != kFigureModes)
    file.fail("figure: covariance has not " + modes + " rows");
  FigureEstimate estimate;
  for (int i = 0; i < kFigureModes; ++i) {
    estimate.mean[i] = file.number(mean[i], "figure: mean");
    if (std::abs(estimate.mean[i]) > kMostCoefficient)
      file.fail("figure: mean tells no human hand");
    if (!covariance[i].is_array() || covariance[i].size() != kFigureModes)
      file.fail("figure: a row of covariance has not " + modes + " numbers");
    for (int k = 0; k < kFigureModes; ++k)
      estimate.covariance(i, k) = file.number(covariance[i][k], "figure: covariance");
  }
  const bool symmetric = estimate.covariance.isApprox(estimate.covariance.transpose(), 1e-6);
  if (!symmetric || estimate.covariance.llt().info() != Eigen::Success)
    file.fail("figure: covariance is not symmetric and positive");
  hand.figure = estimate;
}

HandModel read_fields(const Reader& file) {
  if (file.text("format") != "handyar-hand") file.fail("format is not handyar-hand");
  const Json& version = file.field("version");
  if (!version.is_number_integer()) file.fail("version is not a whole number");
  if (version < 1 || version > 4) {
    file.fail("version " + version.dump() + " is not known, only 1 to 4");
  }
  HandModel hand;
  read_tips(file, hand);
  require_order(file, hand);
  const std::string layout = file.text("layout");
  if (layout != name(Layout::thumb_right) && layout != name(Layout::thumb_left)) {
    file.fail("layout is neither thumb_right nor thumb_left");
  }
  hand.layout = layout == name(Layout::thumb_right) ? Layout::thumb_right : Layout::thumb_left;
  const bool thumb_on_the_right = hand.tips_m(0, 0) > hand.tips_m(0, kFingerCount - 1);
  if (thumb_on_the_right != (hand.layout == Layout::thumb_right)) {
    file.fail("layout is " + layout + ", but the thumb's x in tips_m is on the other side");
  }

  const std::string source = file.text("source");
  const auto known = std::find_if(std::begin(kSources), std::end(kSources),
                                  [&](const auto& s) { return s.first == source; });
  if (known == std::end(kSources)) {
    file.fail("source is none of checkerboard, default, self, truth");
  }
  hand.source = known->second;
  if (file.has("rms_px")) hand.rms_px = file.number_within("rms_px", 0, 1000);
  if (file.has("thickness_m")) {
    hand.thickness_m = file.number_within("thickness_m", 0, kMaxThickness_m);
  }
  if (version >= 2) read_version_2(file, hand);
  if (version >= 4) read_version_4(file, hand);
  return hand;
}

template <std::size_t N>
Json named_points(const Eigen::Matrix<double, 3, static_cast<int>(N)>& points,
                  const std::array<std::string_view, N>& names) {
  Json json;
  for (std::size_t i = 0; i < N; ++i) {
    const Eigen::Vector3d p = points.col(static_cast<int>(i));
    json[std::string(names[i])] = {p.x(), p.y(), p.z()};
  }
  return json;
}

}  // namespace

HandModel parse_hand(std::string_view text, std::string_view name) {
  if (text.size() > kMaxBytes) throw Error(name, "is larger than 64 KiB: not a hand file");
  return parse_json(text, name, [&](const Json& root) { return read_fields(Reader(root, name)); });
}

HandModel read_hand(const std::string& path) { return parse_hand(read_text(path), path); }

std::string format_hand(const HandModel& hand) {
  const bool sigmas = !hand.tips_sigma_m.isZero(0.0);
  Json json;
  json["format"] = "handyar-hand";
  json["version"] = 4;
  json["tips_m"] = named_points(hand.tips_m, kFingerNames);
  json["layout"] = std::string(name(hand.layout));
  for (const auto& [text, source] : kSources) {
    if (source == hand.source) json["source"] = std::string(text);
  }
  json["rms_px"] = hand.rms_px;
  json["thickness_m"] = hand.thickness_m;
  if (hand.average_scale) json["scale"] = "average";
  if (sigmas) json["tips_sigma_m"] = named_points(hand.tips_sigma_m, kFingerNames);
  if (hand.figure) {
    const FigureEstimate& figure = *hand.figure;
    json["figure"]["mean"] = std::vector<double>(figure.mean.begin(), figure.mean.end());
    for (const auto& row : figure.covariance.rowwise())
      json["figure"]["covariance"].push_back(std::vector<double>(row.begin(), row.end()));
  }
  return json.dump(1) + "\n";
}

void write_hand(const std::string& path, const HandModel& hand) {
  write_text(path, format_hand(hand));
}

}  // namespace handyar::io
