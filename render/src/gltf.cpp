// SPDX-License-Identifier: MIT
#include "gltf.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include "handyar/io/json.hpp"

namespace handyar::render {
namespace {

using io::Json;

/// assimp and what draws go down into both by recursion.
constexpr int kDeepestJson = 100, kDeepestNode = 250;

class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : path_(path.string()) {}

  std::vector<TextureTransform> check(std::string_view text) const {
    bool deep = false;
    const auto look = [&](int depth, Json::parse_event_t, const Json&) {
      deep = deep || depth > kDeepestJson;
      return !deep;
    };
    try {
      const Json root = Json::parse(text, look);
      if (deep) fail("its JSON is nested too deeply");
      for (const Json& extension : list(root, "extensionsRequired")) check_extension(extension);
      for (const Json& mesh : list(root, "meshes"))
        for (const Json& primitive : list(mesh, "primitives"))
          check_corners(primitive, list(root, "accessors"));
      if (const Json& animations = list(root, "animations"); !animations.empty())
        for (const Json& sampler : list(animations[0], "samplers"))
          require_floats(sampler, "output", list(root, "accessors"));
      check_nodes(list(root, "nodes"));
      for (const Json& skin : list(root, "skins")) check_skin(skin, list(root, "accessors"));
      for (const Json& image : list(root, "images")) check_image(image);
      std::vector<TextureTransform> laid;
      for (const Json& material : list(root, "materials")) laid.push_back(laid_by(material));
      return laid;
    } catch (const Json::exception& e) {
      fail("is not valid glTF: " + io::fault_of(e));
    }
  }

  /// The JSON in a binary file.
  std::string_view first_chunk(std::string_view bytes) const {
    constexpr std::size_t kHeader = 20;  // magic, version, length; length and kind of the chunk
    if (bytes.size() < kHeader || number(bytes, 8) > bytes.size() ||
        number(bytes, 12) > bytes.size() - kHeader)
      fail("breaks off: its header states more than there is");
    return bytes.substr(kHeader, number(bytes, 12));
  }

 private:
  [[noreturn]] void fail(const std::string& fault) const { throw io::Error(path_, fault); }

  static std::uint32_t number(std::string_view bytes, std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 4; i-- > 0;) value = value << 8 | static_cast<std::uint8_t>(bytes[at + i]);
    return value;
  }

  static const Json& list(const Json& in, const char* key) {
    static const Json none = Json::array();
    const auto found = in.find(key);
    return found != in.end() && found->is_array() ? *found : none;  // in glTF 1 some are objects
  }

  /// Without those that tell how materials answer light, shape and pictures are right all the same.
  void check_extension(const Json& name) const {
    const std::string extension = name.get<std::string>();
    if (extension.starts_with("KHR_materials_") || extension == "KHR_lights_punctual" ||
        extension == "KHR_texture_transform")
      return;
    fail("needs " + extension + ", which is not read");
  }

  /// assimp takes all numbers for floats.
  void require_floats(const Json& in, const std::string& key, const Json& accessors) const {
    constexpr int kFloat = 5126;
    const auto which = in.find(key);
    if (which == in.end() || !which->is_number_unsigned() || *which >= accessors.size()) return;
    if (accessors[which->get<std::size_t>()].value("componentType", kFloat) != kFloat)
      fail("states its " + key + " in whole numbers, which are not read");
  }

  void check_corners(const Json& primitive, const Json& accessors) const {
    const auto attributes = primitive.find("attributes");
    if (attributes == primitive.end()) return;
    for (const char* const key : {"POSITION", "NORMAL", "TEXCOORD_0", "TEXCOORD_1"})
      require_floats(*attributes, key, accessors);
  }

  void check_nodes(const Json& nodes) const {
    std::vector<int> heights(nodes.size(), 0);
    for (std::size_t i = 0; i < nodes.size(); ++i) height(nodes, i, 1, heights);
  }

  /// How many hang on one another from a node down; `heights` holds those known, and 0.
  int height(const Json& nodes, std::size_t which, int depth, std::vector<int>& heights) const {
    if (heights[which] > 0) return heights[which];
    int below = 0;
    if (depth <= kDeepestNode)
      for (const Json& child : list(nodes[which], "children"))
        if (child.is_number_unsigned() && child < nodes.size())
          below = std::max(below, height(nodes, child.get<std::size_t>(), depth + 1, heights));
    if (depth + below > kDeepestNode)
      fail("its nodes hang on one another in a ring, or more than " + std::to_string(kDeepestNode) +
           " deep");
    return heights[which] = below + 1;
  }

  void check_skin(const Json& skin, const Json& accessors) const {
    const std::size_t which = skin.value("inverseBindMatrices", accessors.size());
    if (which >= accessors.size()) fail("has a skin without inverseBindMatrices");
    const Json& matrices = accessors[which];
    if (matrices.value("type", "") != "MAT4" ||
        matrices.value("count", std::size_t{0}) < list(skin, "joints").size())
      fail("has a skin with fewer inverseBindMatrices than joints");
  }

  void check_image(const Json& image) const {
    const std::string kind = image.value("mimeType", "image/");
    if (kind.find('/') == std::string::npos)
      fail("has an image whose mimeType is \"" + kind + "\"");
  }

  /// Of the texture that colours a material, or of what it shines with by itself where none does
  /// (KHR_texture_transform).
  static TextureTransform laid_by(const Json& material) {
    using Where = Json::json_pointer;
    static const Where kColour("/pbrMetallicRoughness/baseColorTexture"),
        kDiffuse("/extensions/KHR_materials_pbrSpecularGlossiness/diffuseTexture"),
        kEmission("/emissiveTexture"), kTransform("/extensions/KHR_texture_transform");
    const Where where = (material.contains(kColour)    ? kColour
                         : material.contains(kDiffuse) ? kDiffuse
                                                       : kEmission) /
                        kTransform;
    TextureTransform transform;
    if (!material.contains(where)) return transform;
    const Json& by = material[where];
    using Pair = std::array<float, 2>;
    const Pair offset = by.value("offset", Pair{0, 0}), scale = by.value("scale", Pair{1, 1});
    transform.laid.translate(Eigen::Vector2f(offset[0], offset[1]));
    transform.laid.rotate(-by.value("rotation", 0.0f));  // stated as seen with v downwards
    transform.laid.scale(Eigen::Vector2f(scale[0], scale[1]));
    if (by.contains("texCoord")) transform.coordinates = by["texCoord"].get<unsigned>();
    return transform;
  }

  std::string path_;
};

}  // namespace

std::vector<TextureTransform> read_gltf(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  const int first = (file >> std::ws).peek();
  if (first != '{' && first != 'g') return {};
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  const Reader reader(path);
  if (first == '{') return reader.check(bytes);
  if (bytes.starts_with("glTF")) return reader.check(reader.first_chunk(bytes));
  return {};
}

}  // namespace handyar::render
