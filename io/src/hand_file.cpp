// SPDX-License-Identifier: MIT
#include "handyar/io/hand_file.hpp"

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
constexpr double kMaxCoordinate_m = 0.5;  // of anything on a hand
constexpr double kMaxHeight_m = 0.12;     // above or below the mean of the fingertips
constexpr double kMaxThickness_m = 0.1;
constexpr std::size_t kMaxOutlinePoints = 10000;

constexpr std::array<std::string_view, kValleyCount> kValleyNames = {"thumb_index", "index_middle",
                                                                     "middle_ring", "ring_little"};

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
    turns += a.x() * b.y() > a.y() * b.x() ? 1 : -1;
  }
  if (std::abs(turns) != kFingerCount - 1) {
    file.fail("tips_m: the fingers do not lie in order from thumb to little");
  }
}

void read_version_3(const Reader& file, HandModel& hand) {
  hand.has_axes = file.has("axis_ends_m") || file.has("axis_roots_m");
  if (!hand.has_axes) return;
  hand.axis_ends_m = file.points("axis_ends_m", kFingerNames);
  hand.axis_roots_m = file.points("axis_roots_m", kFingerNames);
  for (int f = 0; f < kFingerCount; ++f)
    if ((hand.axis_ends_m.col(f) - hand.axis_roots_m.col(f)).norm() < kMinGap_m)
      file.fail("axis_ends_m and axis_roots_m: " + std::string(kFingerNames[f]) +
                " has both at one place");
}

void read_version_2(const Reader& file, HandModel& hand) {
  if (file.has("tips_sigma_m")) {
    hand.tips_sigma_m = file.points("tips_sigma_m", kFingerNames);
    if (hand.tips_sigma_m.minCoeff() < 0) file.fail("tips_sigma_m: a deviation is negative");
  }
  if (file.has("valleys_m")) {
    hand.valleys_m = file.points("valleys_m", kValleyNames);
    hand.has_valleys = true;
  }
  if (file.has("scale")) {
    const std::string scale = file.text("scale");
    if (scale != "measured" && scale != "average") {
      file.fail("scale is neither measured nor average");
    }
    hand.average_scale = scale == "average";
  }
  if (!file.has("outline_m")) return;
  const Json& outline = file.field("outline_m");
  if (!outline.is_array() || outline.size() < 3 || outline.size() > kMaxOutlinePoints) {
    file.fail("outline_m is not a list of 3 to 10000 points");
  }
  for (const Json& point : outline) {
    const std::string what = "outline_m: point " + std::to_string(hand.outline_m.size() + 1);
    if (!point.is_array() || point.size() != 2) file.fail(what + " is not [x, y]");
    const Eigen::Vector2d p(file.number(point[0], what), file.number(point[1], what));
    if (p.cwiseAbs().maxCoeff() > kMaxCoordinate_m) {
      file.fail(what + " is too far off: the unit is the metre");
    }
    hand.outline_m.push_back(p);
  }
}

HandModel read_fields(const Reader& file) {
  if (file.text("format") != "handyar-hand") file.fail("format is not handyar-hand");
  const Json& version = file.field("version");
  if (!version.is_number_integer()) file.fail("version is not a whole number");
  if (version < 1 || version > 3) {
    file.fail("version " + version.dump() + " is not known, only 1 to 3");
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
  if (version >= 3) read_version_3(file, hand);
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
  return parse_json(text, name, [&](const Json& root) { return read_fields(Reader(root, name)); });
}

HandModel read_hand(const std::string& path) { return parse_hand(read_text(path), path); }

std::string format_hand(const HandModel& hand) {
  const bool sigmas = !hand.tips_sigma_m.isZero(0.0);
  const bool version_2 =
      sigmas || hand.has_valleys || !hand.outline_m.empty() || hand.average_scale;
  Json json;
  json["format"] = "handyar-hand";
  json["version"] = hand.has_axes ? 3 : version_2 ? 2 : 1;
  json["tips_m"] = named_points(hand.tips_m, kFingerNames);
  json["layout"] = std::string(name(hand.layout));
  for (const auto& [text, source] : kSources) {
    if (source == hand.source) json["source"] = std::string(text);
  }
  json["rms_px"] = hand.rms_px;
  json["thickness_m"] = hand.thickness_m;
  if (hand.average_scale) json["scale"] = "average";
  if (sigmas) json["tips_sigma_m"] = named_points(hand.tips_sigma_m, kFingerNames);
  if (hand.has_valleys) json["valleys_m"] = named_points(hand.valleys_m, kValleyNames);
  if (hand.has_axes) {
    json["axis_ends_m"] = named_points(hand.axis_ends_m, kFingerNames);
    json["axis_roots_m"] = named_points(hand.axis_roots_m, kFingerNames);
  }
  for (const Eigen::Vector2d& p : hand.outline_m) json["outline_m"].push_back({p.x(), p.y()});
  return json.dump(1) + "\n";
}

void write_hand(const std::string& path, const HandModel& hand) {
  write_text(path, format_hand(hand));
}

}  // namespace handyar::io
