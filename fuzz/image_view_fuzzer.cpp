// SPDX-License-Identifier: MIT
#include <algorithm>
#include <span>
#include <vector>

#include "handyar/paper/tracker.hpp"
#include "handyar/tracker.hpp"

namespace {

using namespace handyar;

constexpr std::size_t kHeader = 5;  // bytes in front of a frame's pixels

/// A view of any format, a size about the smallest, and any stride into memory of exactly the size
/// it needs: a read beside it is found by the address sanitizer.
struct FuzzedFrame {
  std::vector<std::uint8_t> pixels, chroma;
  ImageView view;

  explicit FuzzedFrame(std::span<const std::uint8_t> data) {
    static constexpr int kBytesPerPixel[] = {3, 3, 4, 4, 2, 1, 1};
    view.format = static_cast<PixelFormat>(data[0] % std::size(kBytesPerPixel));
    view.width_px = 156 + data[1] % 64;
    view.height_px = 117 + data[3] % 64;
    const bool bottom_up = (data[2] & 1) != 0;
    const std::ptrdiff_t row = view.width_px * kBytesPerPixel[static_cast<int>(view.format)];
    const std::ptrdiff_t stride = row + data[4] % 70;
    pixels = filled(data.subspan(kHeader), row, stride, view.height_px);
    chroma = filled(data.subspan(kHeader), row, stride, (view.height_px + 1) / 2);
    view.data = pixels.data() + (bottom_up ? stride * (view.height_px - 1) : 0);
    view.stride_bytes = bottom_up ? -stride : stride;
    view.chroma = chroma.data();
    view.chroma_stride_bytes = stride;
  }

  /// Blocks of the data's bytes: shapes take fewer of them than noise, and less time.
  static std::vector<std::uint8_t> filled(std::span<const std::uint8_t> data, std::ptrdiff_t row,
                                          std::ptrdiff_t stride, std::ptrdiff_t rows) {
    constexpr std::size_t kBlock = 24, kBlocksARow = 16;
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(stride * (rows - 1) + row));
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      const std::size_t y = i / static_cast<std::size_t>(stride);
      const std::size_t x = i % static_cast<std::size_t>(stride);
      bytes[i] = data[(x / kBlock + y / kBlock * kBlocksARow) % data.size()];
    }
    return bytes;
  }
};

}  // namespace

// Up to four frames one after the other, each from its share of the data. The trackers are made
// once: that takes longer than all the rest.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const Camera camera = Camera::from_field_of_view(160, 120);
  static HandTracker tracker(camera, average_adult_hand());
  static paper::Tracker paper_tracker(camera, average_adult_hand());
  tracker.reset();
  paper_tracker.reset();
  const std::size_t frames = 1 + (data[0] >> 1) % 4;
  const std::span<const std::uint8_t> rest(data + 1, size - 1);
  const std::size_t share = rest.size() / frames;
  if (share <= kHeader) return 0;
  for (std::size_t i = 0; i < frames; ++i) {
    const FuzzedFrame frame(rest.subspan(i * share, share));
    const double time_s = static_cast<double>(i) / 30.0;
    if ((data[0] & 1) != 0)
      paper_tracker.process(frame.view, time_s);
    else
      tracker.process(frame.view, time_s);
  }
  return 0;
}
