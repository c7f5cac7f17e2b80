// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <optional>
#include <vector>

namespace handyar::render {

/// How the textures of a material lie on a mesh, v downwards.
struct TextureTransform {
  Eigen::Affine2f laid = Eigen::Affine2f::Identity();
  std::optional<unsigned> coordinates;  ///< which of the mesh's, where not those that assimp tells
};

/// What assimp leaves out of a glTF file (text or binary): the transforms of its materials'
/// textures. Empty for files of other formats. Throws io::Error where assimp would end the program,
/// read beyond what is there, never return, or give something else than the file holds: it looks
/// for none of these.
std::vector<TextureTransform> read_gltf(const std::filesystem::path& path);

}  // namespace handyar::render
