// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstring>
#include <vector>

#include "handyar/tracker.hpp"

// Image views of any format, size and stride into memory of exactly the size they need: a read
// beside it is found by the address sanitizer.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace handyar;
  if (size < 8) return 0;
  ImageView view;
  view.format = static_cast<PixelFormat>(data[0] % 7);
  view.width_px = 100 + data[1] * 2 + (data[2] & 1);
  view.height_px = 100 + data[3] + (data[2] >> 1 & 1);
  const int bytes_per_pixel[] = {3, 3, 4, 4, 2, 1, 1};
  const std::ptrdiff_t row = view.width_px * bytes_per_pixel[static_cast<int>(view.format)];
  const std::ptrdiff_t stride = row + data[4] % 70;
  const bool bottom_up = (data[2] & 4) != 0;

  const auto filled = [&](std::ptrdiff_t rows) {
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(stride * (rows - 1) + row));
    for (std::size_t at = 0; at < bytes.size(); at += size - 5) {
      std::memcpy(bytes.data() + at, data + 5, std::min(size - 5, bytes.size() - at));
    }
    return bytes;
  };
  const std::vector<std::uint8_t> pixels = filled(view.height_px);
  const std::vector<std::uint8_t> chroma = filled((view.height_px + 1) / 2);
  view.data = pixels.data() + (bottom_up ? stride * (view.height_px - 1) : 0);
  view.stride_bytes = bottom_up ? -stride : stride;
  view.chroma = chroma.data();
  view.chroma_stride_bytes = stride;

  Config config;
  config.half_resolution = (data[2] & 8) != 0;
  HandTracker tracker(Camera::from_field_of_view(640, 480), average_adult_hand(), config);
  for (int i = 0; i < 3; ++i) tracker.process(view, i / 30.0);
  return 0;
}
