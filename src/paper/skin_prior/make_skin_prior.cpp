// SPDX-License-Identifier: MIT
//
// Writes the skin prior as a table that is compiled into the library: for each bin of colours the
// probability that a pixel of skin, and one of anything else, falls into it, as -log(p) in eighths
// of a nat.
//
//   make_skin_prior OUT.inc

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <span>
#include <vector>

#include "image/color_bin.hpp"
#include "mixture.hpp"

namespace {

using handyar::skin_prior::Gaussian;

constexpr int kCells = 128;  // a channel: finer than the bins
constexpr double kCellWidth = 256.0 / kCells;

double cumulative(double x, double mean, double variance) {
  return 0.5 * std::erfc((mean - x) / std::sqrt(2 * variance));
}

/// Probability of each cell of one channel. What lies beyond 0..255 belongs to the outermost cells,
/// where saturated pixels end.
std::array<double, kCells> along(double mean, double variance) {
  std::array<double, kCells> mass;
  for (int i = 0; i < kCells; ++i) {
    const double low = i == 0 ? 0.0 : cumulative(i * kCellWidth, mean, variance);
    const double high = i == kCells - 1 ? 1.0 : cumulative((i + 1) * kCellWidth, mean, variance);
    mass[i] = high - low;
  }
  return mass;
}

std::vector<double> bins_of(std::span<const Gaussian> mixture) {
  std::vector<std::array<std::array<double, kCells>, 3>> axes;
  for (const Gaussian& g : mixture)
    axes.push_back({along(g.mean_rgb[0], g.variance_rgb[0]),
                    along(g.mean_rgb[1], g.variance_rgb[1]),
                    along(g.mean_rgb[2], g.variance_rgb[2])});
  const auto level = [](int cell) { return static_cast<int>((cell + 0.5) * kCellWidth); };
  std::vector<double> bins(handyar::kBinCount);
  for (int r = 0; r < kCells; ++r)
    for (int g = 0; g < kCells; ++g)
      for (int b = 0; b < kCells; ++b) {
        double mass = 0;
        for (std::size_t k = 0; k < axes.size(); ++k)
          mass += mixture[k].weight * axes[k][0][r] * axes[k][1][g] * axes[k][2][b];
        bins[handyar::bin_of_rgb(level(r), level(g), level(b))] += mass;
      }
  return bins;
}

void write(std::FILE* file, std::span<const double> bins) {
  int column = 0;
  for (const double p : bins) {
    const double eighths = -8 * std::log(std::max(p, 1e-13));
    std::fprintf(file, "%d,", static_cast<int>(std::clamp(std::lround(eighths), 0L, 255L)));
    if (++column % 32 == 0) std::fputc('\n', file);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  std::FILE* file = std::fopen(argv[1], "w");
  if (file == nullptr) return 1;
  write(file, bins_of(handyar::skin_prior::kSkin));
  write(file, bins_of(handyar::skin_prior::kNonSkin));
  return std::fclose(file) == 0 ? 0 : 1;
}
