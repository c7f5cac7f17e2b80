// SPDX-License-Identifier: MIT
//
// Writes the skin prior as a table that is compiled into the library: for each of the 32^3 bins of
// RGB the probability that a pixel of skin, and one of anything else, falls into it, as
// -log(p) in eighths of a nat.
//
//   make_skin_prior OUT.inc

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "mixture.hpp"

namespace {

constexpr int kLevels = 32;
constexpr double kBinWidth = 256.0 / kLevels;

double cumulative(double x, double mean, double variance) {
  return 0.5 * std::erfc((mean - x) / std::sqrt(2 * variance));
}

/// Probability mass of every bin. Mass beyond 0..255 belongs to the outermost bins, where saturated
/// pixels end.
void add(const handyar::skin_prior::Gaussian& g, double (&mass)[kLevels][kLevels][kLevels]) {
  double axis[3][kLevels];
  for (int c = 0; c < 3; ++c)
    for (int i = 0; i < kLevels; ++i) {
      const double low = i == 0 ? 0.0 : cumulative(i * kBinWidth, g.mean_rgb[c], g.variance_rgb[c]);
      const double high = i == kLevels - 1
                              ? 1.0
                              : cumulative((i + 1) * kBinWidth, g.mean_rgb[c], g.variance_rgb[c]);
      axis[c][i] = high - low;
    }
  for (int r = 0; r < kLevels; ++r)
    for (int gr = 0; gr < kLevels; ++gr)
      for (int b = 0; b < kLevels; ++b)
        mass[r][gr][b] += g.weight * axis[0][r] * axis[1][gr] * axis[2][b];
}

void write(std::FILE* file, const double (&mass)[kLevels][kLevels][kLevels]) {
  int column = 0;
  for (const auto& plane : mass)
    for (const auto& row : plane)
      for (const double p : row) {
        const double eighths = -8 * std::log(std::max(p, 1e-13));
        std::fprintf(file, "%d,", static_cast<int>(std::clamp(std::lround(eighths), 0L, 255L)));
        if (++column % 32 == 0) std::fputc('\n', file);
      }
}

double skin[kLevels][kLevels][kLevels], non_skin[kLevels][kLevels][kLevels];

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  for (const auto& g : handyar::skin_prior::kSkin) add(g, skin);
  for (const auto& g : handyar::skin_prior::kNonSkin) add(g, non_skin);
  std::FILE* file = std::fopen(argv[1], "w");
  if (file == nullptr) return 1;
  write(file, skin);
  write(file, non_skin);
  return std::fclose(file) == 0 ? 0 : 1;
}
