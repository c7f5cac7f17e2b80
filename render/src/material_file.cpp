// SPDX-License-Identifier: MIT
#include "material_file.hpp"

#include <assimp/GltfMaterial.h>
#include <assimp/material.h>
#include <assimp/scene.h>

#include <cmath>
#include <initializer_list>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>

#include "handyar/io/error.hpp"
#include "handyar/io/picture_file.hpp"
#include "uri.hpp"

namespace handyar::render {
namespace {

namespace fs = std::filesystem;

// The picture that `read` gives; `name` is what the model calls it.
template <class Read>
cv::Mat texture(const fs::path& model, const std::string& name, Read read) {
  try {
    return read(io::PictureOptions{.pixels = io::PictureOptions::Pixels::rgba});
  } catch (const io::Error&) {
    throw io::Error(model.string(), "its " + name + " cannot be read");
  }
}

// A file's bytes of RGBA; `name` is what the model calls it.
cv::Mat read_picture(const aiScene& scene, const aiString& name, const fs::path& model) {
  if (const aiTexture* embedded = scene.GetEmbeddedTexture(name.C_Str())) {
    const auto* const bytes = reinterpret_cast<const std::uint8_t*>(embedded->pcData);
    if (embedded->mHeight == 0)  // a compressed file of mWidth bytes
      return texture(model, "embedded texture", [&](const auto& options) {
        return io::decode_picture({bytes, embedded->mWidth}, "", options);
      });
    const cv::Mat bgra(static_cast<int>(embedded->mHeight), static_cast<int>(embedded->mWidth),
                       CV_8UC4, embedded->pcData);
    cv::Mat rgba;
    cv::cvtColor(bgra, rgba, cv::COLOR_BGRA2RGBA);
    return rgba;
  }
  if (name.length == 0) throw io::Error(model.string(), "has a texture without a picture");
  const std::string file = file_named((model.parent_path() / name.C_Str()).string());
  return texture(model, "texture " + file,
                 [&](const auto& options) { return io::read_picture(file, options); });
}

// "OPAQUE", "MASK" or "BLEND"; empty where the material is not of a glTF file.
std::string gltf_mode(const aiMaterial& material) {
  aiString mode;
  material.Get(AI_MATKEY_GLTF_ALPHAMODE, mode);
  return mode.C_Str();
}

// In older files of glTF a diffuse colour and this tell what is no metal; what the newer way says
// is then assimp's invention.
std::optional<float> glossiness_of(const aiMaterial& material) {
  float glossiness = 0;
  if (gltf_mode(material).empty() ||
      material.Get(AI_MATKEY_GLOSSINESS_FACTOR, glossiness) != aiReturn_SUCCESS)
    return std::nullopt;
  return glossiness;
}

constexpr auto kColour = {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE};
// What is drawn has all textures of a material laid alike: as the one that colours it, or, where
// there is none, as that of what it shines with by itself.
constexpr auto kLaying = {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE, aiTextureType_EMISSIVE};

// Of a material's texture: its file, which of a mesh's coordinates lay it, and how it goes on
// beyond its edges.
struct LaidTexture {
  aiString file;
  unsigned coordinates = 0;
  aiTextureMapMode modes[2] = {aiTextureMapMode_Wrap, aiTextureMapMode_Wrap};
};

// The first of these kinds that the material has.
std::optional<LaidTexture> texture_of(const aiMaterial& material,
                                      std::initializer_list<aiTextureType> kinds) {
  LaidTexture texture;
  for (const auto kind : kinds)
    if (material.GetTexture(kind, 0, &texture.file, nullptr, &texture.coordinates, nullptr, nullptr,
                            texture.modes) == aiReturn_SUCCESS)
      return texture;
  return std::nullopt;
}

Wrap wrap_of(aiTextureMapMode mode) {
  if (mode == aiTextureMapMode_Mirror) return Wrap::mirror;
  return mode == aiTextureMapMode_Wrap ? Wrap::repeat : Wrap::clamp;
}

void read_texture(const aiScene& scene, const aiMaterial& material, const fs::path& model,
                  Material& out) {
  const auto texture = texture_of(material, kColour);
  if (!texture) return;
  cv::Mat& rgba = out.texture;
  rgba = read_picture(scene, texture->file, model);
  const std::string mode = gltf_mode(material);
  float cutoff = 0;
  if (mode == "MASK") material.Get(AI_MATKEY_GLTF_ALPHACUTOFF, cutoff);
  if (cutoff > 0)  // what draws it has holes where alpha is below a half
    cv::multiply(rgba, cv::Scalar(1, 1, 1, 0.5 / cutoff), rgba);
  else if (mode == "OPAQUE" || mode == "MASK")  // what lies in alpha means nothing
    rgba |= cv::Scalar(0, 0, 0, 255);
}

// Of glTF alone: what other formats call emission is often a rest of the program's own lights.
void read_emission(const aiScene& scene, const aiMaterial& in, const fs::path& model,
                   Material& out) {
  aiColor4D colour;
  if (gltf_mode(in).empty() || in.Get(AI_MATKEY_COLOR_EMISSIVE, colour) != aiReturn_SUCCESS) return;
  out.emission = srgb(colour, true);
  if (out.emission.isZero()) return;
  if (const auto texture = texture_of(in, {aiTextureType_EMISSIVE}))
    out.emission_texture = read_picture(scene, texture->file, model);
}

// What is drawn has one roughness a material, and is metal or not in one measure: the mean of what
// a texture tells.
void read_surface(const aiScene& scene, const aiMaterial& in, const fs::path& model,
                  Material& out) {
  float shininess = 0;
  if (in.Get(AI_MATKEY_ROUGHNESS_FACTOR, out.roughness) != aiReturn_SUCCESS &&
      in.Get(AI_MATKEY_SHININESS, shininess) == aiReturn_SUCCESS && shininess > 0)
    out.roughness = std::sqrt(2 / (shininess + 2));
  in.Get(AI_MATKEY_METALLIC_FACTOR, out.metallic);
  if (const auto glossiness = glossiness_of(in)) {
    out.roughness = 1 - *glossiness;
    out.metallic = 0;
  }
  aiString file;
  if (gltf_mode(in).empty() ||
      in.GetTexture(AI_MATKEY_GLTF_PBRMETALLICROUGHNESS_METALLICROUGHNESS_TEXTURE, &file) !=
          aiReturn_SUCCESS)
    return;
  const cv::Scalar mean = cv::mean(read_picture(scene, file, model)) / 255;
  out.roughness *= static_cast<float>(mean[1]);
  out.metallic *= static_cast<float>(mean[2]);
}

}  // namespace

bool states_linear_light(const aiMaterial& material) { return !gltf_mode(material).empty(); }

Eigen::Vector3f srgb(const aiColor4D& colour, bool linear) {
  const Eigen::Vector3f stated(colour.r, colour.g, colour.b);
  if (!linear) return stated;
  return stated.array().max(0).pow(1 / 2.2f);
}

unsigned texture_coordinates_of(const aiMaterial& material) {
  return texture_of(material, kLaying).value_or(LaidTexture{}).coordinates;
}

Material read_material(const aiScene& scene, const aiMaterial& in, const fs::path& model) {
  Material out;
  aiColor4D colour;
  if (!glossiness_of(in) && in.Get(AI_MATKEY_BASE_COLOR, colour) == aiReturn_SUCCESS)
    out.colour = srgb(colour, true);
  else if (in.Get(AI_MATKEY_COLOR_DIFFUSE, colour) == aiReturn_SUCCESS)
    out.colour = srgb(colour, !gltf_mode(in).empty());
  read_surface(scene, in, model, out);
  const LaidTexture laid = texture_of(in, kLaying).value_or(LaidTexture{});
  out.wrap_u = wrap_of(laid.modes[0]);
  out.wrap_v = wrap_of(laid.modes[1]);
  read_texture(scene, in, model, out);
  read_emission(scene, in, model, out);
  return out;
}

}  // namespace handyar::render
