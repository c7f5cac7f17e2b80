// SPDX-License-Identifier: MIT
#include "find/samples.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "image/pixel_reader.hpp"

namespace handyar {
namespace {

// Of one sample at most so many pixels a side are read: of large frames not all.
constexpr int kMostReads = 4;
constexpr int kMostSamples = 160;  // a side
constexpr float kGrey = 127.5f;    // beyond the frame

// Where a read lies is the sum of where its column and its row begin, in fixed point.
constexpr int kFractionBits = 16;
using FixedPlace = std::array<std::int64_t, 2>;
using FixedPlaces = std::array<FixedPlace, kMostSamples * kMostReads>;

FixedPlaces places(const Eigen::Vector2f& first_px, const Eigen::Vector2f& step_px, int count,
                   int reads) {
  FixedPlaces all;
  for (int i = 0; i < count * reads; ++i) {
    const float samples = (static_cast<float>(i) + 0.5f) / static_cast<float>(reads) - 0.5f;
    const Eigen::Vector2f px = first_px + samples * step_px;
    all[i] = {std::llround(std::ldexp(px.x(), kFractionBits)),
              std::llround(std::ldexp(px.y(), kFractionBits))};
  }
  return all;
}

}  // namespace

void take_samples(const ImageView& frame, const SampleGrid& grid, std::span<float> rgb) noexcept {
  const PixelReader reader(frame);
  const int reads = std::clamp(static_cast<int>(std::lround(grid.right_px.norm())), 1, kMostReads);
  const FixedPlaces columns = places(grid.first_px + Eigen::Vector2f(0.5f, 0.5f), grid.right_px,
                                     grid.width, reads),
                    rows = places({0, 0}, grid.down_px, grid.height, reads);
  float* out = rgb.data();
  for (int v = 0; v < grid.height; ++v)
    for (int u = 0; u < grid.width; ++u, out += 3) {
      std::array<int, 3> sum{};
      int within = 0;
      for (int j = v * reads; j < (v + 1) * reads; ++j)
        for (int i = u * reads; i < (u + 1) * reads; ++i) {
          const std::int64_t x = (columns[i][0] + rows[j][0]) >> kFractionBits,
                             y = (columns[i][1] + rows[j][1]) >> kFractionBits;
          if (x < 0 || y < 0 || x >= frame.width_px || y >= frame.height_px) continue;
          const std::array<int, 3> read = reader.rgb(static_cast<int>(x), static_cast<int>(y));
          for (int c = 0; c < 3; ++c) sum[c] += read[c];
          ++within;
        }
      for (int c = 0; c < 3; ++c) out[c] = within > 0 ? static_cast<float>(sum[c]) / within : kGrey;
    }
}

}  // namespace handyar
