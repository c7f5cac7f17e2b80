// SPDX-License-Identifier: MIT
#include <cmath>
#include <cstdlib>

#include "handyar/io/camera_file.hpp"
#include "handyar/io/error.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const auto camera =
        handyar::io::parse_camera({reinterpret_cast<const char*>(data), size}, "fuzz");
    if (!std::isfinite(camera.fx_px) || !(camera.fy_px > 0)) std::abort();
  } catch (const handyar::io::Error&) {
  }
  return 0;
}
