// SPDX-License-Identifier: MIT
#pragma once

#include <assimp/types.h>

#include <Eigen/Core>
#include <filesystem>

#include "handyar/render/model.hpp"

struct aiMaterial;
struct aiScene;

namespace handyar::render {

/// A material of a file that assimp has read, with its pictures. Throws io::Error that names the
/// file `model` where one cannot be read.
Material read_material(const aiScene& scene, const aiMaterial& in,
                       const std::filesystem::path& model);

/// Which of a mesh's coordinates lay the material's textures.
unsigned texture_coordinates_of(const aiMaterial& material);

/// glTF states linear light; everything here is sRGB.
bool states_linear_light(const aiMaterial& material);
Eigen::Vector3f srgb(const aiColor4D& colour, bool linear);

}  // namespace handyar::render
