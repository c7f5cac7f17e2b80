// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <vector>

namespace handyar::render {

/// What assimp leaves out of a glTF file (text or binary): by which transform the texture that
/// colours each material lies, v downwards. Empty for files of other formats. Throws io::Error
/// where assimp would end the program, read beyond what is there, or never return: it looks for
/// none of these.
std::vector<Eigen::Affine2f> read_gltf(const std::filesystem::path& path);

}  // namespace handyar::render
