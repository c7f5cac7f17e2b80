// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "handyar/image_view.hpp"

namespace handyar {

/// Colour, quantised to 5 bits each of luma (the highest bits), yellowness and redness: Y, -Cb and
/// Cr of BT.601 in full range. Luma goes in steps of 8. Chroma goes in steps of 2 from -8 to 40,
/// where greys and skin of every tone lie, and in steps of 32 beyond: a hand and what looks like
/// one differ by little.
using ColorBin = std::uint16_t;
inline constexpr int kBinLevels = 32;
inline constexpr int kBinCount = kBinLevels * kBinLevels * kBinLevels;
inline constexpr int kFineChroma = 4, kCoarseChroma = 28;  ///< the fine levels, from, to before

/// Bin of luma and chromas times 256. In 16 bits throughout: a vector holds twice as many.
constexpr ColorBin color_bin(std::uint16_t luma256, std::int16_t yellowness256,
                             std::int16_t redness256) noexcept {
  using Short = std::int16_t;
  const auto level = [](Short chroma256) {
    constexpr Short kFrom = -8 * 256, kTo = 40 * 256;
    const Short fine = std::clamp(chroma256, kFrom, kTo);
    return Short(kFineChroma - (kFrom >> 9) + (fine >> 9) + (Short(chroma256 - fine) >> 13));
  };
  return static_cast<ColorBin>(ColorBin(ColorBin(luma256 >> 11) << 10) |
                               ColorBin(level(yellowness256) << 5) | ColorBin(level(redness256)));
}

/// Bin of a colour, 0..255.
constexpr ColorBin bin_of_rgb(int r, int g, int b) noexcept {
  return color_bin(static_cast<std::uint16_t>(77 * r + 150 * g + 29 * b),
                   static_cast<std::int16_t>(43 * r + 85 * g - 128 * b),
                   static_cast<std::int16_t>(128 * r - 107 * g - 21 * b));
}

/// Bin of a colour as cameras deliver it: luma 16..235, chroma 16..240, or beyond like the ends.
constexpr ColorBin bin_of_ycbcr(int y, int cb, int cr) noexcept {
  const auto chroma = [](int c) {
    return static_cast<std::int16_t>(std::clamp(291 * c, -32768, 32767));
  };
  return color_bin(static_cast<std::uint16_t>(std::clamp(298 * (y - 16), 0, 65535)),
                   chroma(128 - cb), chroma(cr - 128));
}

/// A bin's centre: Y, Cb and Cr, the chromas about 0.
constexpr std::array<double, 3> ycbcr_of(ColorBin bin) noexcept {
  const auto chroma = [](int level) {
    return level < kFineChroma     ? 32 * level - 120.0
           : level < kCoarseChroma ? 2 * level - 15.0
                                   : 32 * level - 840.0;
  };
  return {(bin >> 10) * 8 + 4.0, -chroma(bin >> 5 & 31), chroma(bin & 31)};
}

/// RGB of a bin's centre; of a bin that no colour falls into, beyond 0..255.
Eigen::Vector3d rgb_of(ColorBin bin) noexcept;

/// A rectangle of pixels: x0_px <= x < x0_px + width_px.
struct PixelRect {
  int x0_px = 0, y0_px = 0, width_px = 0, height_px = 0;
};

/// Where in a frame colour bins lie, possibly reduced: bin (u, v) is the mean colour of up to four
/// of the step x step input pixels from (x0_px + u * step_px, y0_px + v * step_px) on, in the
/// middle of which their mean lies.
struct BinGrid {
  int width = 0, height = 0;
  int x0_px = 0, y0_px = 0, step_px = 1;

  /// Input pixel coordinates of the centre of bin (u, v).
  double x_px(double u) const noexcept { return x0_px + u * step_px + 0.5 * (step_px - 1); }
  double y_px(double v) const noexcept { return y0_px + v * step_px + 0.5 * (step_px - 1); }
  Eigen::Vector2f origin_px() const noexcept { return {float(x_px(0)), float(y_px(0))}; }
};

/// Bins that lie elsewhere, or a part of them.
struct BinView : BinGrid {
  const ColorBin* first = nullptr;
  std::ptrdiff_t stride = 0;  ///< bins from row to row

  const ColorBin* row(int v) const noexcept { return first + v * stride; }
  ColorBin at(int u, int v) const noexcept { return row(v)[u]; }
  /// Columns u0 <= u < u1 of rows v0 <= v < v1, all within.
  BinView part(int u0, int v0, int u1, int v1) const noexcept {
    const BinGrid cut{u1 - u0, v1 - v0, x0_px + u0 * step_px, y0_px + v0 * step_px, step_px};
    return {cut, row(v0) + u0, stride};
  }
};

/// Bins and the room they lie in.
struct BinImage : BinGrid {
  std::vector<ColorBin> bins;  ///< row by row, width * height used

  std::span<const ColorBin> used() const noexcept {
    return {bins.data(), static_cast<std::size_t>(width) * height};
  }
  operator BinView() const noexcept { return {*this, bins.data(), width}; }
};

/// Reads `roi` (cut to the frame) of a checked frame at 1/step of its size. `out.bins` must have
/// room for the result; of each step x step block at most four pixels are averaged.
void read_bins(const ImageView& frame, const PixelRect& roi, int step_px, BinImage& out) noexcept;

}  // namespace handyar
