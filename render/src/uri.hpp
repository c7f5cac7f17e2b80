// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace handyar::render {

/// The file of that name or, where there is none, the one whose name was written on Windows, with
/// \, or of which it is the URI, as names in glTF are: "%20" stands for a space.
std::string file_named(const std::string& name);

}  // namespace handyar::render
