// SPDX-License-Identifier: MIT
#include "handyar/render/scene.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "handyar/io/error.hpp"
#include "handyar/io/json.hpp"
#include "handyar/io/pending_file.hpp"
#include "handyar/opencv/aruco.hpp"

namespace handyar::render {
namespace {

using json = io::Json;

/// Reads one scene; `at_` says where in the file for messages.
class Reader {
 public:
  explicit Reader(const std::string& path) : path_(path) {}

  Scene read(const json& root) {
    if (!root.is_object()) fail("is not a scene: an object with \"objects\" is expected");
    if (root.value("format", json()) != "handyar-scene")
      fail("\"format\" is not \"handyar-scene\"");
    if (root.value("version", json()) != 1) fail("\"version\" is not 1");
    expect_only(root, {"format", "version", "world", "objects"});
    if (root.contains("world")) read_world(root["world"]);
    at_.clear();
    // On a map the first object is put down when the table is recognised, which may take another
    // run.
    if (!root.contains("objects") || !root["objects"].is_array() ||
        (root["objects"].empty() && scene_.map.empty()))
      fail("\"objects\" is missing or empty");
    for (std::size_t i = 0; i < root["objects"].size(); ++i) {
      at_ = "object " + std::to_string(i + 1) + ": ";
      read_object(root["objects"][i]);
    }
    return std::move(scene_);
  }

 private:
  [[noreturn]] void fail(const std::string& fault) const { throw io::Error(path_, at_ + fault); }

  std::filesystem::path folder() const { return std::filesystem::path(path_).parent_path(); }

  /// A slip in a key would go unnoticed where the key may be missing.
  void expect_only(const json& in, std::initializer_list<std::string_view> known) const {
    if (!in.is_object()) fail("an object in braces is expected");
    for (const auto& [key, value] : in.items())
      if (std::find(known.begin(), known.end(), key) == known.end())
        fail("\"" + key + "\" is not known here");
  }

  const json& field(const json& in, const char* key) const {
    if (!in.is_object()) fail("an object in braces is expected");
    const auto it = in.find(key);
    if (it == in.end()) fail(std::string("\"") + key + "\" is missing");
    return *it;
  }

  double number(const json& in, const char* key, double low, double high) const {
    const json& v = field(in, key);
    if (!v.is_number() || !(v >= low && v <= high)) {
      char range[80];
      std::snprintf(range, sizeof range, "\" is not a number from %g to %g", low, high);
      fail(std::string("\"") + key + range);
    }
    return v;
  }

  int whole(const json& in, const char* key, int low, int high) const {
    const double v = number(in, key, low, high);
    if (v != std::floor(v)) fail(std::string("\"") + key + "\" is not a whole number");
    return static_cast<int>(v);
  }

  std::string word(const json& in, const char* key) const {
    const json& v = field(in, key);
    if (!v.is_string() || v.get_ref<const std::string&>().empty())
      fail(std::string("\"") + key + "\" is not a text");
    return v;
  }

  Eigen::Vector3d triple(const json& in, const char* key) const {
    if (!in.contains(key)) return Eigen::Vector3d::Zero();
    const json& v = in[key];
    Eigen::Vector3d out;
    if (!v.is_array() || v.size() != 3) fail(std::string("\"") + key + "\" is not three numbers");
    for (int i = 0; i < 3; ++i) {
      if (!v[i].is_number()) fail(std::string("\"") + key + "\" is not three numbers");
      if (!(std::abs(v[i].get<double>()) <= 1e6))
        fail(std::string("\"") + key + "\": " + v[i].dump() + " is not from -1e6 to 1e6");
      out[i] = v[i];
    }
    return out;
  }

  /// Turned about the fixed axes x, then y, then z; then moved.
  Eigen::Isometry3d pose(const json& in) const {
    if (!in.contains("pose")) return Eigen::Isometry3d::Identity();
    const json& v = in["pose"];
    if (!v.is_object()) fail("\"pose\" is not an object in braces");
    expect_only(v, {"position_mm", "rotation_deg"});
    const Eigen::Vector3d angles_rad = triple(v, "rotation_deg") * (M_PI / 180);
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translation() = triple(v, "position_mm") / 1000;
    T.linear() = (Eigen::AngleAxisd(angles_rad.z(), Eigen::Vector3d::UnitZ()) *
                  Eigen::AngleAxisd(angles_rad.y(), Eigen::Vector3d::UnitY()) *
                  Eigen::AngleAxisd(angles_rad.x(), Eigen::Vector3d::UnitX()))
                     .toRotationMatrix();
    return T;
  }

  Eigen::Vector3f colour(const json& in) const {
    if (!in.contains("colour")) return Eigen::Vector3f::Ones();
    const std::string text = word(in, "colour");
    if (text.size() != 7 || text[0] != '#' ||
        text.find_first_not_of("0123456789abcdefABCDEF", 1) != std::string::npos)
      fail("\"colour\" is not like \"#rrggbb\"");
    const auto part = [&](std::size_t at) {
      return static_cast<float>(std::stoi(text.substr(at, 2), nullptr, 16));
    };
    return Eigen::Vector3f(part(1), part(3), part(5)) / 255;
  }

  Attachment attachment(const json& in) const {
    const std::string text = word(in, "attach");
    if (const auto where = find_attachment(text)) return *where;
    fail("\"attach\": \"" + text +
         "\" is no place of the hand (known are face, palm, back, wrist, " +
         "thumb_base ... little_base, thumb_tip ... little_tip)");
  }

  SceneMarker marker(const json& in) const {
    SceneMarker m;
    m.dictionary = word(in, "dictionary");
    if (!dictionary_number(m.dictionary))
      fail("unknown marker dictionary \"" + m.dictionary + "\" (known are OpenCV's, like " +
           "DICT_4X4_50 or DICT_APRILTAG_36h11)");
    m.id = whole(in, "id", 0, dictionary_size(*dictionary_number(m.dictionary)) - 1);
    m.size_m = number(in, "size_mm", 1, 10000) / 1000;
    return m;
  }

  /// Index of the same print among the markers so far, -1 when there is none.
  int find(const SceneMarker& m) const {
    for (std::size_t i = 0; i < scene_.markers.size(); ++i)
      if (scene_.markers[i].dictionary == m.dictionary && scene_.markers[i].id == m.id)
        return static_cast<int>(i);
    return -1;
  }

  void read_world(const json& world) {
    at_ = "world: ";
    expect_only(world, {"markers", "board", "map"});
    if (world.contains("map")) {
      if (world.size() > 1) fail("has \"map\" and markers");
      scene_.map = (folder() / word(world, "map")).string();
      return;
    }
    if (world.contains("board")) read_board(world["board"]);
    if (world.contains("markers")) {
      if (!world["markers"].is_array()) fail("\"markers\" is not a list");
      for (const json& in : world["markers"]) {
        expect_only(in, {"dictionary", "id", "size_mm", "pose"});
        SceneMarker m = marker(in);
        m.T_world_marker = pose(in);
        add_to_world(m);
      }
    }
    if (scene_.markers.empty()) fail("has neither \"markers\" nor a \"board\" nor a \"map\"");
  }

  void add_to_world(const SceneMarker& m) {
    if (find(m) >= 0) fail("marker " + std::to_string(m.id) + " is named twice");
    scene_.markers.push_back(m);
  }

  /// Markers in rows from the top left, ids rising; the world's origin is the board's centre, x
  /// right, y up, z out of the print.
  void read_board(const json& in) {
    expect_only(in, {"dictionary", "id", "columns", "rows", "size_mm", "gap_mm"});
    const int columns = whole(in, "columns", 1, 100), rows = whole(in, "rows", 1, 100);
    const double gap_m = number(in, "gap_mm", 0, 10000) / 1000;
    json first = in;
    if (!first.contains("id")) first["id"] = 0;
    SceneMarker m = marker(first);
    const int known = dictionary_size(*dictionary_number(m.dictionary));
    if (m.id + rows * columns > known)
      fail("the board needs ids up to " + std::to_string(m.id + rows * columns - 1) + ", " +
           m.dictionary + " has " + std::to_string(known));
    const double pitch_m = m.size_m + gap_m;
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns; ++column, ++m.id) {
        m.T_world_marker = Eigen::Isometry3d(Eigen::Translation3d(
            pitch_m * (column - 0.5 * (columns - 1)), pitch_m * (0.5 * (rows - 1) - row), 0));
        add_to_world(m);
      }
  }

  void read_object(const json& in) {
    const bool has_world =
        !scene_.map.empty() || (!scene_.markers.empty() && scene_.markers.front().T_world_marker);
    expect_only(in, {"name", "marker", "model", "colour", "size_mm", "pose", "attach"});
    SceneObject o;
    o.model = word(in, "model");
    if (o.model != "teapot" && o.model != "bunny") o.model = (folder() / o.model).string();
    o.name = in.contains("name") ? word(in, "name")
                                 : "object " + std::to_string(scene_.objects.size() + 1);
    for (const SceneObject& other : scene_.objects)
      if (other.name == o.name) fail("the name \"" + o.name + "\" is used twice");
    o.colour = colour(in);
    if (in.contains("size_mm")) o.size_m = number(in, "size_mm", 1, 10000) / 1000;
    if (in.contains("attach")) o.attachment = attachment(in);
    o.T_marker_object = pose(in);
    if (in.contains("marker")) {
      expect_only(in["marker"], {"dictionary", "id", "size_mm"});
      const SceneMarker m = marker(in["marker"]);
      o.marker = find(m);
      for (const SceneObject& other : scene_.objects)
        if (o.marker >= 0 && other.marker == o.marker)
          fail("\"" + other.name + "\" is already on marker " + std::to_string(m.id) + " of " +
               m.dictionary);
      if (o.marker < 0) {
        if (has_world) fail("marker " + std::to_string(m.id) + " is not part of the world");
        o.marker = static_cast<int>(scene_.markers.size());
        scene_.markers.push_back(m);
      } else if (scene_.markers[o.marker].size_m != m.size_m) {
        fail("marker " + std::to_string(m.id) + " has another size in the world");
      }
    } else if (!has_world) {
      fail("\"marker\" is missing");
    }
    scene_.objects.push_back(o);
  }

  std::string path_, at_;
  Scene scene_;
};

/// To a thousandth, of a millimetre or a degree.
json triple_of(const Eigen::Vector3d& v) {
  const Eigen::Vector3d rounded = (1000 * v).array().round() / 1000;
  return {rounded.x(), rounded.y(), rounded.z()};
}

json pose_of(const Eigen::Isometry3d& T) {
  const Eigen::Vector3d zyx_rad = T.linear().eulerAngles(2, 1, 0);
  json out;
  out["position_mm"] = triple_of(1000 * T.translation());
  out["rotation_deg"] = triple_of(zyx_rad.reverse() * (180 / M_PI));
  return out;
}

std::string colour_of(const Eigen::Vector3f& colour) {
  const Eigen::Vector3i c = (255 * colour).array().round().cast<int>();
  char text[8];
  std::snprintf(text, sizeof text, "#%02x%02x%02x", c[0] & 255, c[1] & 255, c[2] & 255);
  return text;
}

}  // namespace

Scene parse_scene(std::string_view text, const std::string& path) {
  return io::parse_json(text, path, [&](const json& root) { return Reader(path).read(root); });
}

void write_scene(const std::string& path, const Scene& scene) {
  namespace fs = std::filesystem;
  const auto from_folder = [&](const std::string& file) {
    return fs::proximate(file, fs::absolute(path).parent_path()).string();
  };
  json root = {{"format", "handyar-scene"},
               {"version", 1},
               {"world", {{"map", from_folder(scene.map)}}},
               {"objects", json::array()}};
  for (const SceneObject& o : scene.objects) {
    const bool built_in = o.model == "teapot" || o.model == "bunny";
    root["objects"].push_back({{"name", o.name},
                               {"model", built_in ? o.model : from_folder(o.model)},
                               {"colour", colour_of(o.colour)},
                               {"size_mm", 1000 * o.size_m},
                               {"attach", name(o.attachment)},
                               {"pose", pose_of(o.T_marker_object)}});
  }
  std::string text;
  try {
    text = root.dump(1) + "\n";
  } catch (const json::exception& e) {  // a name that is not UTF-8
    throw io::Error(path, "cannot be written: " + io::fault_of(e));
  }
  io::write_text(path, text);
}

Scene read_scene(const std::string& path) { return parse_scene(io::read_text(path), path); }

}  // namespace handyar::render
