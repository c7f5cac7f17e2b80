// SPDX-License-Identifier: MIT
#include "handyar/chroma_noise.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "vectorised.hpp"

namespace handyar {
namespace {

/// Averages over squares of 2 kRadius + 1 bins; each of the rows holds sums over columns, of one
/// chroma in the upper byte, of the other in the lower: five levels fit.
template <int kRadius, class Rows>
[[gnu::always_inline]] inline void smooth_over(BinImage& image, Rows& rows) {
  constexpr int kSide = 2 * kRadius + 1;
  constexpr std::uint32_t kShare = 65536 / (kSide * kSide) + 1;
  const int w = image.width, h = image.height;
  const auto chroma = [](ColorBin bin) { return (bin >> 5 & 31) << 8 | (bin & 31); };
  const auto sum_row = [&](int v) {
    const ColorBin* row = image.bins.data() + v * w;
    std::uint16_t* to = rows[v % kSide].data();
    int sum = 0;
    for (int k = -kRadius; k <= kRadius; ++k) sum += chroma(row[std::clamp(k, 0, w - 1)]);
    for (int u = 0; u < w; ++u) {
      to[u] = static_cast<std::uint16_t>(sum);
      sum += chroma(row[std::min(u + kRadius + 1, w - 1)]) - chroma(row[std::max(u - kRadius, 0)]);
    }
  };
  for (int v = 0; v < std::min(kRadius, h); ++v) sum_row(v);
  for (int v = 0; v < h; ++v) {
    if (v + kRadius < h) sum_row(v + kRadius);
    std::array<const std::uint16_t*, kSide> around;
    for (int k = 0; k < kSide; ++k)
      around[k] = rows[std::clamp(v + k - kRadius, 0, h - 1) % kSide].data();
    ColorBin* to = image.bins.data() + v * w;
    for (int u = 0; u < w; ++u) {
      std::uint32_t upper = 0, lower = 0;
      for (int k = 0; k < kSide; ++k) {
        upper += around[k][u] >> 8;
        lower += around[k][u] & 255;
      }
      const auto mean = [](std::uint32_t sum) { return (sum * kShare + 32768) >> 16; };
      to[u] = static_cast<ColorBin>((to[u] & 31 << 10) | mean(upper) << 5 | mean(lower));
    }
  }
}

}  // namespace

float chroma_noise(const BinView& image, int stride) noexcept {
  constexpr int kApart = 4;  // beyond what a camera's halved chroma and its coding share
  std::array<int, 4 * kBinLevels> count{};
  int samples = 0;
  for (int v = 0; v < image.height; v += stride) {
    const ColorBin* row = image.row(v);
    for (int u = kApart; u + kApart < image.width; u += stride)
      for (const int shift : {0, 5}) {
        const auto level = [&](int at) { return row[at] >> shift & (kBinLevels - 1); };
        ++count[std::abs(level(u - kApart) - 2 * level(u) + level(u + kApart))];
        ++samples;
      }
  }
  if (samples == 0) return 0;
  int below = 0, median = 0;
  while (below + count[median] <= samples / 2) below += count[median++];
  const float within = (static_cast<float>(samples) / 2 - static_cast<float>(below)) /
                       static_cast<float>(count[median]);
  const float middle = std::max(0.0f, static_cast<float>(median) - 0.5f + within);
  return middle / (0.6745f * std::sqrt(6.0f));  // of second differences of Gaussian noise
}

void ChromaSmoother::reserve(int max_width) {
  for (auto& row : rows_) row.resize(max_width);
}

HANDYAR_VECTORISED void ChromaSmoother::smooth(int radius, BinImage& image) noexcept {
  if (image.width == 0 || radius < 1) return;
  if (radius == 1)
    smooth_over<1>(image, rows_);
  else
    smooth_over<2>(image, rows_);
}

}  // namespace handyar
