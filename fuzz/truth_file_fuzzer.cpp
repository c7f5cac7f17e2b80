// SPDX-License-Identifier: MIT
#include <cstdlib>

#include "handyar/evaluation/truth.hpp"
#include "handyar/io/error.hpp"
#include "memory_file.hpp"

// What was read can be compared with: a camera with a size, markers that can be seen.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace handyar;
  const fuzz::MemoryFile file(data, size);
  try {
    const evaluation::Truth truth = evaluation::read_truth(file.path());
    if (truth.camera.width_px <= 0 || !(truth.camera.fx_px > 0)) std::abort();
    for (const evaluation::Marker& marker : truth.markers)
      if (!(marker.size_m > 0)) std::abort();
  } catch (const io::Error&) {
  }
  return 0;
}
