// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "handyar/io/json.hpp"
#include "handyar/io/pending_file.hpp"
#include "handyar/io/picture_file.hpp"
#include "handyar/world/world_map.hpp"
#include "picture.hpp"

namespace handyar::world {
namespace {

using io::Json;

// One line of JSON, then the keyframes' pictures (PNG) one after the other.
constexpr int kVersion = 1;
constexpr std::size_t kMostKeyframes = 1000, kMostPoints = 100'000, kMostBytes = 1u << 30;
// Sixty keyframes of the largest camera; PNGs of one colour are a thousandth of their pixels.
constexpr std::size_t kMostPixels = std::size_t{60} * 4096 * 2160;
constexpr double kLargest = 1e4;

class Reader {
 public:
  Reader(const Json& root, std::string_view name) : root_(root), name_(name) {}

  WorldMap read(std::string_view pictures) {
    if (!root_.is_object() || root_.value("format", Json()) != "handyar-map")
      fail("is not a map of handyar");
    if (root_.value("version", Json()) != kVersion) fail("\"version\" is not 1");
    read_camera();
    const Json& scale = root_.at("scale");
    if (scale != "measured" && scale != "assumed")
      fail("\"scale\" is neither measured nor assumed");
    map_.scale_assumed = scale == "assumed";
    map_.hand_thickness_m = number(root_.at("hand_thickness_m"), 0.1);
    read_ground();
    read_points();
    read_keyframes(pictures);
    return std::move(map_);
  }

 private:
  [[noreturn]] void fail(const std::string& fault) const { throw io::Error(name_, fault); }

  double number(const Json& value, double most) const {
    const double x = value.get<double>();
    if (!(std::abs(x) <= most)) fail("a number is beyond reason");
    return x;
  }
  const Json& list(const Json& value, std::size_t size, const char* what) const {
    if (!value.is_array() || value.size() != size)
      fail(std::string(what) + " has not " + std::to_string(size) + " numbers");
    return value;
  }
  const Json& list_up_to(const char* key, const Json& value, std::size_t most) const {
    if (!value.is_array() || value.size() > most)
      fail(std::string("\"") + key + "\" is no list of at most " + std::to_string(most));
    return value;
  }

  void read_camera() {
    const Json& in = root_.at("camera");
    Camera& camera = map_.camera;
    camera.width_px = in.at("width_px").get<int>();
    camera.height_px = in.at("height_px").get<int>();
    const auto size = [](int px) { return px >= 64 && px <= 8192; };
    if (!size(camera.width_px) || !size(camera.height_px))
      fail("the camera's size is beyond reason");
    const Json& matrix = list(in.at("fx_fy_cx_cy_px"), 4, "fx_fy_cx_cy_px");
    camera.fx_px = number(matrix[0], 1e5);
    camera.fy_px = number(matrix[1], 1e5);
    camera.cx_px = number(matrix[2], 1e5);
    camera.cy_px = number(matrix[3], 1e5);
    if (camera.fx_px < 10 || camera.fy_px < 10) fail("the camera's focal length is beyond reason");
    const Json& distortion = list(in.at("distortion"), 5, "distortion");
    for (std::size_t i = 0; i < 5; ++i) camera.distortion[i] = number(distortion[i], 100);
  }

  void read_ground() {
    const Json& in = list(root_.at("ground"), 4, "ground");
    Eigen::Vector4d c;
    for (int i = 0; i < 4; ++i) c[i] = number(in[static_cast<std::size_t>(i)], kLargest);
    if (std::abs(c.head<3>().norm() - 1) > 1e-3) fail("\"ground\" has no normal of length 1");
    map_.ground.coeffs() = c;
    map_.ground.normalize();
  }

  void read_points() {
    for (const Json& in : list_up_to("points", root_.at("points"), kMostPoints)) {
      list(in, 4, "a point");
      MapPoint point;
      for (int i = 0; i < 3; ++i)
        point.p_world_m[i] = number(in[static_cast<std::size_t>(i)], kLargest);
      point.plane_sigma_m = number(in[3], kLargest);
      if (point.plane_sigma_m < 0) fail("a point's plane_sigma_m is negative");
      map_.points.push_back(point);
    }
  }

  int point_number(const Json& value) const {
    const auto number = value.get<std::int64_t>();
    if (number < 0 || number >= std::ssize(map_.points))
      fail("a keyframe shows a point that is not there");
    return static_cast<int>(number);
  }

  Eigen::Isometry3d pose(const Json& in) const {
    list(in, 7, "a pose");
    double q[7];
    for (std::size_t i = 0; i < 7; ++i) q[i] = number(in[i], kLargest);
    const Eigen::Quaterniond turn(q[0], q[1], q[2], q[3]);
    if (std::abs(turn.norm() - 1) > 1e-3) fail("a pose's quaternion has not length 1");
    Eigen::Isometry3d T(turn.normalized());
    T.translation() = Eigen::Vector3d(q[4], q[5], q[6]);
    return T;
  }

  void read_keyframes(std::string_view pictures) {
    const Json& list = list_up_to("keyframes", root_.at("keyframes"), kMostKeyframes);
    if (list.empty()) fail("has no keyframe");
    if (list.size() * static_cast<std::size_t>(map_.camera.width_px) *
            static_cast<std::size_t>(map_.camera.height_px) >
        kMostPixels)
      fail("its keyframes are larger than 60 of 4096x2160 pixels");
    for (const Json& in : list) {
      Keyframe keyframe;
      keyframe.T_camera_world = pose(in.at("pose"));
      keyframe.hand_in_view = in.at("hand_in_view").get<bool>();
      const auto bytes = in.at("bytes").get<std::int64_t>();
      if (bytes <= 0 || bytes > std::ssize(pictures)) fail("ends within a picture");
      keyframe.grey = picture(pictures.substr(0, static_cast<std::size_t>(bytes)));
      pictures.remove_prefix(static_cast<std::size_t>(bytes));
      for (const Json& o : list_up_to("seen", in.at("seen"), kMostPoints)) {
        this->list(o, 3, "what is seen");
        keyframe.observations.push_back(
            {point_number(o[0]),
             {within(o[1], map_.camera.width_px), within(o[2], map_.camera.height_px)}});
      }
      read_corners(in, keyframe);
      map_.keyframes.push_back(std::move(keyframe));
    }
    if (!pictures.empty()) fail("has more after its last picture");
  }

  double within(const Json& value, int size) const {
    const double x = value.get<double>();
    if (!(x >= 0 && x < size)) fail("a pixel lies outside of its picture");
    return x;
  }

  cv::Mat picture(std::string_view bytes) const {
    // The size is looked at before the pixels take memory: in a PNG it stands at the start.
    const auto big_endian = [&](std::size_t at) {
      std::uint32_t value = 0;
      for (std::size_t i = 0; i < 4; ++i)
        value = value << 8 | static_cast<std::uint8_t>(bytes[at + i]);
      return value;
    };
    constexpr std::string_view kPng("\x89PNG\r\n\x1a\n", 8);
    const bool fits = bytes.size() > 24 && bytes.starts_with(kPng) &&
                      big_endian(16) == static_cast<std::uint32_t>(map_.camera.width_px) &&
                      big_endian(20) == static_cast<std::uint32_t>(map_.camera.height_px);
    if (!fits) fail("a picture is no PNG of the camera's size");
    const std::span raw(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    try {
      return io::decode_picture(raw, name_, {io::PictureOptions::Pixels::grey, false});
    } catch (const io::Error&) {
      fail("a picture cannot be read");
    }
  }

  void read_corners(const Json& in, Keyframe& keyframe) const {
    for (const Json& c : list_up_to("corners", in.at("corners"), kMostPoints)) {
      list(c, 6, "a corner");
      cv::KeyPoint corner;
      corner.pt = {static_cast<float>(within(c[0], map_.camera.width_px)),
                   static_cast<float>(within(c[1], map_.camera.height_px))};
      corner.size = static_cast<float>(number(c[2], 1000));
      corner.angle = static_cast<float>(number(c[3], 360));
      corner.octave = c[4].get<int>();
      if (corner.octave < 0 || corner.octave >= kCornerLevels) fail("a corner's octave is unknown");
      corner.class_id = c[5].is_null() ? -1 : point_number(c[5]);
      keyframe.corners.push_back(corner);
    }
    keyframe.descriptors = describe(keyframe.grey, keyframe.corners);
    for (const cv::KeyPoint& corner : keyframe.corners)
      keyframe.corner_points.push_back(corner.class_id);
  }

  const Json& root_;
  std::string_view name_;
  WorldMap map_;
};

Json header(const WorldMap& map, const std::vector<std::vector<std::uint8_t>>& pictures) {
  Json json;
  json["format"] = "handyar-map";
  json["version"] = kVersion;
  const Camera& c = map.camera;
  json["camera"] = {{"width_px", c.width_px},
                    {"height_px", c.height_px},
                    {"fx_fy_cx_cy_px", {c.fx_px, c.fy_px, c.cx_px, c.cy_px}},
                    {"distortion", c.distortion}};
  json["scale"] = map.scale_assumed ? "assumed" : "measured";
  json["hand_thickness_m"] = map.hand_thickness_m;
  const Eigen::Vector4d ground = map.ground.coeffs();
  json["ground"] = {ground[0], ground[1], ground[2], ground[3]};
  json["points"] = Json::array();
  for (const MapPoint& p : map.points)
    json["points"].push_back({p.p_world_m.x(), p.p_world_m.y(), p.p_world_m.z(), p.plane_sigma_m});
  for (std::size_t k = 0; k < map.keyframes.size(); ++k) {
    const Keyframe& keyframe = map.keyframes[k];
    Json out;
    const Eigen::Quaterniond q(keyframe.T_camera_world.linear());
    const Eigen::Vector3d t = keyframe.T_camera_world.translation();
    out["pose"] = {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()};
    out["hand_in_view"] = keyframe.hand_in_view;
    out["bytes"] = pictures[k].size();
    out["seen"] = Json::array();
    for (const Observation& o : keyframe.observations)
      out["seen"].push_back({o.point, o.px.x(), o.px.y()});
    out["corners"] = Json::array();
    for (std::size_t i = 0; i < keyframe.corners.size(); ++i) {
      const cv::KeyPoint& corner = keyframe.corners[i];
      const int point = keyframe.corner_points[i];
      out["corners"].push_back({corner.pt.x, corner.pt.y, corner.size, corner.angle, corner.octave,
                                point < 0 ? Json() : Json(point)});
    }
    json["keyframes"].push_back(std::move(out));
  }
  return json;
}

}  // namespace

WorldMap parse_map(std::string_view bytes, std::string_view name) {
  const std::size_t end = bytes.find('\n');
  if (end == std::string_view::npos || bytes.front() != '{')
    throw io::Error(name, "is not a map of handyar");
  return io::parse_json(bytes.substr(0, end), name, [&](const Json& root) {
    return Reader(root, name).read(bytes.substr(end + 1));
  });
}

WorldMap read_map(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) throw io::Error(path, "cannot be opened");
  const auto size = file.tellg();
  if (size < 0 || static_cast<std::uintmax_t>(size) > kMostBytes)
    throw io::Error(path, "is not a map of handyar");
  std::string bytes(static_cast<std::size_t>(size), '\0');
  file.seekg(0);
  if (!file.read(bytes.data(), size)) throw io::Error(path, "cannot be read");
  return parse_map(bytes, path);
}

void write_map(const std::string& path, const WorldMap& map) {
  std::vector<std::vector<std::uint8_t>> pictures(map.keyframes.size());
  for (std::size_t k = 0; k < pictures.size(); ++k)
    pictures[k] = io::encode_picture(map.keyframes[k].grey, ".png", path);
  std::string bytes = header(map, pictures).dump() + "\n";
  for (const auto& picture : pictures) bytes.append(picture.begin(), picture.end());
  io::write_text(path, bytes);
}

}  // namespace handyar::world
