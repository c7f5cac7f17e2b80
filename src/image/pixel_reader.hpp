// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <tuple>

#include "handyar/image_view.hpp"
#include "image/color_bin.hpp"
#include "vectorised.hpp"

namespace handyar {

/// Pixels by their three numbers as a frame has them: red, green, blue, or luma and both chromas.
struct PixelGroup {
  static constexpr int kMost = 32;
  using Numbers = std::array<std::uint16_t, kMost>;
  Numbers first{}, second{}, third{};
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
  HANDYAR_ALWAYS_INLINE bool covers(float x, float y) const noexcept {
    return (x >= -0.5f) & (y >= -0.5f) & (x < right_) & (y < bottom_);
  }
  /// Of the pixel that covers a place, or that is nearest to it.
  HANDYAR_ALWAYS_INLINE int nearest_x(float x) const noexcept { return nearest(x, right_); }
  HANDYAR_ALWAYS_INLINE int nearest_y(float y) const noexcept { return nearest(y, bottom_); }

  /// Red, green, blue, 0 to 255.
  std::array<int, 3> rgb(int x, int y) const noexcept {
    const auto [first, second, third] = numbers(x, y);
    if (bytes_ != 0) return {first, second, third};
    const int luma = 298 * (first - 16), cb = second - 128, cr = third - 128;
    const auto byte = [](int value256) { return std::clamp(value256 >> 8, 0, 255); };
    return {byte(luma + 409 * cr), byte(luma - 100 * cb - 208 * cr), byte(luma + 516 * cb)};
  }

  /// Luma, 0 to 255, between the four pixels around a place.
  float luma(float x, float y) const noexcept {
    const int left = static_cast<int>(x), top = static_cast<int>(y);
    const float a = x - static_cast<float>(left), b = y - static_cast<float>(top);
    return (1 - b) * ((1 - a) * luma(left, top) + a * luma(left + 1, top)) +
           b * ((1 - a) * luma(left, top + 1) + a * luma(left + 1, top + 1));
  }

  ColorBin bin(int x, int y) const noexcept {
    const auto [first, second, third] = numbers(x, y);
    return bytes_ != 0 ? bin_of_rgb(first, second, third) : bin_of_ycbcr(first, second, third);
  }

  /// Puts a pixel at place `i` of a group.
  HANDYAR_ALWAYS_INLINE void read(int x, int y, int i, PixelGroup& group) const noexcept {
    std::tie(group.first[i], group.second[i], group.third[i]) = numbers(x, y);
  }

  /// Colour bins and luma (0 to 255) of all of a group, in vectors.
  void tell(const PixelGroup& group, std::array<ColorBin, PixelGroup::kMost>& bins,
            PixelGroup::Numbers& luma) const noexcept {
    const auto& [first, second, third] = group;
    if (bytes_ == 0) {
      for (int i = 0; i < PixelGroup::kMost; ++i) {
        bins[i] = bin_of_ycbcr(first[i], second[i], third[i]);
        luma[i] = luma256_of_y(first[i]) >> 8;
      }
      return;
    }
    for (int i = 0; i < PixelGroup::kMost; ++i) {
      bins[i] = bin_of_rgb(first[i], second[i], third[i]);
      luma[i] = luma256_of_rgb(first[i], second[i], third[i]) >> 8;
    }
  }

 private:
  HANDYAR_ALWAYS_INLINE static int nearest(float at, float last) noexcept {
    return static_cast<int>(std::min(last, std::max(0.0f, at + 0.5f)));
  }
  float luma(int x, int y) const noexcept {
    const auto [first, second, third] = numbers(x, y);
    return static_cast<float>(bytes_ != 0 ? luma256_of_rgb(first, second, third)
                                          : luma256_of_y(first)) /
           256;
  }

  HANDYAR_ALWAYS_INLINE std::tuple<std::uint8_t, std::uint8_t, std::uint8_t> numbers(
      int x, int y) const noexcept {
    const std::uint8_t* row = frame_.data + y * frame_.stride_bytes;
    if (bytes_ != 0) {
      const std::uint8_t* p = row + x * bytes_;
      return {p[red_], p[1], p[2 - red_]};
    }
    if (frame_.format == PixelFormat::nv12) {
      const std::uint8_t* pair = frame_.chroma + (y / 2) * frame_.chroma_stride_bytes + (x & ~1);
      return {row[x], pair[0], pair[1]};
    }
    const std::uint8_t* pair = row + (x & ~1) * 2;
    return {row[x * 2], pair[1], pair[3]};
  }

  const ImageView& frame_;
  float right_, bottom_;
  int bytes_ = 0, red_ = 0;
};

}  // namespace handyar
