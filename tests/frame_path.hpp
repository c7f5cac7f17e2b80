// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

/// A frame in memory; `format` as PixelFormat's.
struct FrameBytes {
  const std::uint8_t* data;
  int width_px, height_px;
  std::ptrdiff_t stride_bytes;
  int format;
};

/// All that the stages make of a frame, one after the other.
using FramePath = std::vector<float>;

namespace handyar {
FramePath read_colors(const FrameBytes& frame, int step_px);
FramePath look_for_hand(const FrameBytes& frame);
}  // namespace handyar
