// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "handyar/image_view.hpp"

namespace handyar {

/// Colour, quantised to 5 bits a channel in the frame's own colour space: RGB for bgr, rgb, bgra
/// and rgba, YCbCr for yuyv and nv12. The first channel (R or Y) holds the highest bits.
using ColorBin = std::uint16_t;
inline constexpr int kBinLevels = 32;
inline constexpr int kBinCount = kBinLevels * kBinLevels * kBinLevels;

enum class ColorSpace : std::uint8_t { rgb, ycbcr };
ColorSpace color_space(PixelFormat format) noexcept;

/// RGB, 0..255, of a bin's centre. YCbCr is BT.601 in video range (luma 16..235, chroma 16..240),
/// as cameras deliver it; what it can express beyond RGB comes out beyond 0..255.
Eigen::Vector3d rgb_of(ColorBin bin, ColorSpace space) noexcept;

/// A rectangle of pixels: x0_px <= x < x0_px + width_px.
struct PixelRect {
  int x0_px = 0, y0_px = 0, width_px = 0, height_px = 0;
};

/// A part of a frame as colour bins, possibly reduced: bin (u, v) is the mean colour of the
/// step x step input pixels from (x0_px + u * step_px, y0_px + v * step_px) on.
struct BinImage {
  int width = 0, height = 0;
  int x0_px = 0, y0_px = 0, step_px = 1;
  std::vector<ColorBin> bins;  ///< row by row, width * height used

  std::span<const ColorBin> used() const noexcept {
    return {bins.data(), static_cast<std::size_t>(width) * height};
  }
  /// Input pixel coordinates of the centre of bin (u, v).
  double x_px(double u) const noexcept { return x0_px + u * step_px + 0.5 * (step_px - 1); }
  double y_px(double v) const noexcept { return y0_px + v * step_px + 0.5 * (step_px - 1); }
  Eigen::Vector2f origin_px() const noexcept { return {float(x_px(0)), float(y_px(0))}; }
};

/// Reads `roi` (cut to the frame) of a checked frame at 1/step of its size. `out.bins` must have
/// room for the result; of each step x step block at most four pixels are averaged.
void read_bins(const ImageView& frame, const PixelRect& roi, int step_px, BinImage& out) noexcept;

}  // namespace handyar
