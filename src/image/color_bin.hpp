// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>

namespace handyar {

/// Colour, quantised to 4 bits of luma (the highest) and 5 bits each of yellowness and redness: Y,
/// -Cb and Cr of BT.601 in full range. Luma goes in steps of 16. Chroma goes in steps of 2 from -8
/// to 40, where greys and skin of every tone lie, and in steps of 32 beyond: a hand and what looks
/// like one differ by little.
using ColorBin = std::uint16_t;
inline constexpr int kLumaLevels = 16, kBinLevels = 32;  ///< of luma, of each chroma
inline constexpr int kLumaShift = 10;
inline constexpr int kBinCount = kLumaLevels * kBinLevels * kBinLevels;
inline constexpr int kFineChroma = 4;  ///< the first of the fine levels

/// Bin of luma and chromas times 256. In 16 bits throughout: a vector holds twice as many.
constexpr ColorBin color_bin(std::uint16_t luma256, std::int16_t yellowness256,
                             std::int16_t redness256) noexcept {
  using Short = std::int16_t;
  const auto level = [](Short chroma256) {
    constexpr Short kFrom = -8 * 256, kTo = 40 * 256;
    const Short fine = std::clamp(chroma256, kFrom, kTo);
    return Short(kFineChroma - (kFrom >> 9) + (fine >> 9) + (Short(chroma256 - fine) >> 13));
  };
  return static_cast<ColorBin>(ColorBin(ColorBin(luma256 >> 12) << kLumaShift) |
                               ColorBin(level(yellowness256) << 5) | ColorBin(level(redness256)));
}

/// Luma, times 256, of a colour 0..255.
constexpr std::uint16_t luma256_of_rgb(int r, int g, int b) noexcept {
  return static_cast<std::uint16_t>(77 * r + 150 * g + 29 * b);
}

/// The same of luma as cameras deliver it, 16..235.
constexpr std::uint16_t luma256_of_y(int y) noexcept {
  return static_cast<std::uint16_t>(std::clamp(298 * (y - 16), 0, 65535));
}

/// Bin of a colour, 0..255.
constexpr ColorBin bin_of_rgb(int r, int g, int b) noexcept {
  return color_bin(luma256_of_rgb(r, g, b), static_cast<std::int16_t>(43 * r + 85 * g - 128 * b),
                   static_cast<std::int16_t>(128 * r - 107 * g - 21 * b));
}

/// Bin of a colour as cameras deliver it: luma 16..235, chroma 16..240, or beyond like the ends.
constexpr ColorBin bin_of_ycbcr(int y, int cb, int cr) noexcept {
  const auto chroma = [](int c) {
    return static_cast<std::int16_t>(std::clamp(291 * c, -32768, 32767));
  };
  return color_bin(luma256_of_y(y), chroma(128 - cb), chroma(cr - 128));
}

}  // namespace handyar
