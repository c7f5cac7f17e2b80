// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

namespace handyar::render {

/// True when the file is a PLY with less in it than its header and its lists count. assimp does not
/// look: it reads on, or makes room for any number.
bool is_ply_cut_short(const std::filesystem::path& path);

}  // namespace handyar::render
