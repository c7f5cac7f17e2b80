// SPDX-License-Identifier: MIT
#include <cmath>
#include <cstdlib>

#include "handyar/io/error.hpp"
#include "handyar/render/scene.hpp"

// What was read can be drawn: numbers are finite, indices lie within, names are each there once.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace handyar;
  try {
    const auto scene = render::parse_scene({reinterpret_cast<const char*>(data), size}, "fuzz");
    if (scene.objects.empty()) std::abort();
    for (const render::SceneObject& object : scene.objects) {
      const bool within = object.marker >= -1 && object.marker < std::ssize(scene.markers);
      if (!within || !(object.size_m > 0) || object.name.empty()) std::abort();
      if (!object.T_marker_object.matrix().allFinite()) std::abort();
    }
    for (const render::SceneMarker& marker : scene.markers)
      if (!(marker.size_m > 0) || marker.id < 0) std::abort();
  } catch (const io::Error&) {
  }
  return 0;
}
