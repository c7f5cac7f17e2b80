// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

namespace handyar::render {

/// Refuses a glTF file (text or binary) at which assimp ends the program, reads beyond what is
/// there, or never returns: it looks for neither. Files of other formats pass. Throws io::Error.
void check_gltf(const std::filesystem::path& path);

}  // namespace handyar::render
