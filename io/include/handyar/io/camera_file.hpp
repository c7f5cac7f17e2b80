// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

#include "handyar/camera.hpp"

namespace handyar::io {

/// Reads an OpenCV or ROS camera file (docs/formats.md). Everything is checked; throws Error naming
/// file and field.
Camera read_camera(const std::string& path);

/// The same from text; `name` stands for the file in messages.
Camera parse_camera(std::string_view text, std::string_view name);

void write_camera(const std::string& path, const Camera& camera);

/// The camera for pictures of another size: scaled when the aspect is the same (to within a pixel)
/// or it is an assumed one, else an Error that names `path`.
Camera camera_for_size(const Camera& camera, int width_px, int height_px, const std::string& path);

}  // namespace handyar::io
