// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "handyar/color_bins.hpp"

namespace handyar {

/// From which noise on chroma is averaged, as chroma_noise() tells it.
struct ChromaNoiseConfig {
  double tracked = 1.1;      ///< around a hand that is followed
  double lasting = 0.8;      ///< times that, once it is averaged
  double searched = 1.5;     ///< in reduced frames, whose details look like noise too
  double width_share = 0.1;  ///< of a finger's width: how far around it is averaged
};

/// How much the chroma of bins differs by chance, as a standard deviation in fine levels: from the
/// median of second differences along rows, which borders and slow changes hardly move. Looks at
/// every `stride`th bin each way.
float chroma_noise(const BinView& image, int stride = 8) noexcept;

/// Averages chroma over squares and leaves luma: dim light makes a camera's colours noisy, and
/// chroma, which cameras deliver at half the resolution anyway, tells hands from what looks like
/// them, while luma shows where they end.
class ChromaSmoother {
 public:
  static constexpr int kMaxRadius = 2;

  /// Room for rows of up to `max_width` bins.
  void reserve(int max_width);

  /// Over squares of 2 radius + 1 bins each way, at most kMaxRadius; below 1, nothing changes. The
  /// image's borders are repeated.
  void smooth(int radius, BinImage& image) noexcept;

 private:
  std::array<std::vector<std::uint16_t>, 2 * kMaxRadius + 1> rows_;  ///< summed over columns
};

}  // namespace handyar
