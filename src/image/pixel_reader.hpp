// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "handyar/image_view.hpp"
#include "image/color_bin.hpp"

namespace handyar {

/// A pixel's colour bin and its luma, 0..255.
struct Pixel {
  ColorBin bin = 0;
  int luma = 0;
};

/// Single pixels of a checked frame, whatever its format.
class PixelReader {
 public:
  explicit PixelReader(const ImageView& frame) noexcept
      : frame_(frame),
        right_(static_cast<float>(frame.width_px) - 0.5f),
        bottom_(static_cast<float>(frame.height_px) - 0.5f) {
    switch (frame.format) {
      case PixelFormat::rgb:
        bytes_ = 3, red_ = 0;
        break;
      case PixelFormat::bgr:
        bytes_ = 3, red_ = 2;
        break;
      case PixelFormat::rgba:
        bytes_ = 4, red_ = 0;
        break;
      case PixelFormat::bgra:
        bytes_ = 4, red_ = 2;
        break;
      default:
        bytes_ = 0;
    }
  }

  /// Of pixel centres: (0, 0) is that of the first.
  bool covers(float x, float y) const noexcept {
    return x >= -0.5f && y >= -0.5f && x < right_ && y < bottom_;
  }

  /// Red, green, blue, 0 to 255.
  std::array<int, 3> rgb(int x, int y) const noexcept {
    const std::uint8_t* row = frame_.data + y * frame_.stride_bytes;
    if (bytes_ != 0) {
      const std::uint8_t* p = row + x * bytes_;
      return {p[red_], p[1], p[2 - red_]};
    }
    const bool planes = frame_.format == PixelFormat::nv12;
    const std::uint8_t* pair = planes
                                   ? frame_.chroma + (y / 2) * frame_.chroma_stride_bytes + (x & ~1)
                                   : row + (x & ~1) * 2;
    const int luma = 298 * ((planes ? row[x] : row[x * 2]) - 16);
    const int cb = pair[planes ? 0 : 1] - 128, cr = pair[planes ? 1 : 3] - 128;
    const auto byte = [](int value256) { return std::clamp(value256 >> 8, 0, 255); };
    return {byte(luma + 409 * cr), byte(luma - 100 * cb - 208 * cr), byte(luma + 516 * cb)};
  }

  Pixel at(int x, int y) const noexcept {
    const std::uint8_t* row = frame_.data + y * frame_.stride_bytes;
    if (bytes_ != 0) {
      const std::uint8_t* p = row + x * bytes_;
      const int r = p[red_], g = p[1], b = p[2 - red_];
      return {bin_of_rgb(r, g, b), (77 * r + 150 * g + 29 * b) >> 8};
    }
    if (frame_.format == PixelFormat::nv12) {
      const std::uint8_t* pair = frame_.chroma + (y / 2) * frame_.chroma_stride_bytes + (x & ~1);
      return {bin_of_ycbcr(row[x], pair[0], pair[1]), row[x]};
    }
    const std::uint8_t* pair = row + (x & ~1) * 2;
    return {bin_of_ycbcr(row[x * 2], pair[1], pair[3]), row[x * 2]};
  }

 private:
  const ImageView& frame_;
  float right_, bottom_;
  int bytes_ = 0, red_ = 0;
};

}  // namespace handyar
