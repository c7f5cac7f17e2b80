// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace handyar::io {

/// Path of something shipped with the project, e.g. "sample/video.mp4": beside the installed
/// program or in the source tree it was built from. Throws Error when it is in neither.
std::string data_file(const std::string& name);

}  // namespace handyar::io
