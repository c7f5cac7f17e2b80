// SPDX-License-Identifier: MIT
#include "handyar/chroma_noise.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "synthetic_hand.hpp"

namespace handyar {
namespace {

constexpr int kWidth = 160, kHeight = 120;

int chroma_level(ColorBin bin, int shift) { return bin >> shift & (kBinLevels - 1); }

/// A picture in which `level_at` tells the mean level of both chromas, give or take `sigma` levels,
/// the same over 2x2 bins, as cameras deliver it; luma is anything.
template <class LevelAt>
BinImage picture(const LevelAt& level_at, double sigma, const std::string& name) {
  BinImage image;
  image.width = kWidth;
  image.height = kHeight;
  image.bins.resize(kWidth * kHeight);
  std::mt19937 rng = test::random_for(name);
  for (int v = 0; v < kHeight; v += 2)
    for (int u = 0; u < kWidth; u += 2) {
      ColorBin chroma = 0;
      for (const int shift : {0, 5}) {
        const long level = std::lround(level_at(u, v) + test::gauss(rng, sigma));
        chroma = static_cast<ColorBin>(chroma | std::clamp(level, 0L, 31L) << shift);
      }
      for (const int at :
           {v * kWidth + u, v * kWidth + u + 1, (v + 1) * kWidth + u, (v + 1) * kWidth + u + 1})
        image.bins[at] = static_cast<ColorBin>(chroma | (rng() & 31) << 10);
    }
  return image;
}

const auto level = [](int, int) { return 16.0; };

TEST(ChromaNoise, IsTheNoisesStandardDeviation) {
  for (const double sigma : {0.5, 1.0, 2.0, 4.0}) {
    const BinImage image = picture(level, sigma, "ChromaNoise" + std::to_string(sigma));
    EXPECT_NEAR(chroma_noise(image, 3), sigma, 0.12 * sigma + 0.05) << sigma;
  }
}

TEST(ChromaNoise, BordersAndSlowChangesAreNone) {
  const auto slow = [](int u, int v) { return 0.1 * u + 0.1 * v; };
  const auto squares = [](int u, int v) { return u / 48 % 2 == v / 48 % 2 ? 8.0 : 20.0; };
  EXPECT_LT(chroma_noise(picture(slow, 0, "slow"), 3), 0.6) << "rounding alone";
  EXPECT_LT(chroma_noise(picture(squares, 0, "squares"), 3), 0.5);
  EXPECT_NEAR(chroma_noise(picture(squares, 1, "squares"), 3), 1, 0.3);
}

TEST(ChromaNoise, NothingAndLittleToLookAt) {
  EXPECT_EQ(chroma_noise(BinImage{}), 0);
  const BinImage image = picture(level, 3, "little");
  EXPECT_EQ(chroma_noise(BinView(image).part(10, 10, 18, 90)), 0) << "as wide as a difference";
  EXPECT_TRUE(std::isfinite(chroma_noise(BinView(image).part(0, 0, 40, 1))));
}

TEST(ChromaSmoother, GivesTheMeanOfTheSquareAround) {
  const BinImage before = picture(level, 4, "mean");
  ChromaSmoother smoother;
  smoother.reserve(kWidth);
  for (int radius = 1; radius <= ChromaSmoother::kMaxRadius; ++radius) {
    BinImage image = before;
    smoother.smooth(radius, image);
    for (int v = 0; v < kHeight; ++v)
      for (int u = 0; u < kWidth; ++u)
        for (const int shift : {0, 5}) {
          double sum = 0;
          for (int dv = -radius; dv <= radius; ++dv)
            for (int du = -radius; du <= radius; ++du)
              sum += chroma_level(before.bins[std::clamp(v + dv, 0, kHeight - 1) * kWidth +
                                              std::clamp(u + du, 0, kWidth - 1)],
                                  shift);
          ASSERT_NEAR(chroma_level(image.bins[v * kWidth + u], shift),
                      sum / ((2 * radius + 1) * (2 * radius + 1)), 0.52)
              << u << " " << v << " radius " << radius;
        }
  }
}

TEST(ChromaSmoother, LeavesLumaAndWhatIsEven) {
  ChromaSmoother smoother;
  smoother.reserve(kWidth);
  for (const double extreme : {0.0, 31.0}) {
    const BinImage even = picture([=](int, int) { return extreme; }, 0, "even");
    BinImage image = even;
    smoother.smooth(ChromaSmoother::kMaxRadius, image);
    EXPECT_EQ(image.bins, even.bins);
  }
  const BinImage noisy = picture(level, 4, "luma");
  BinImage image = noisy;
  smoother.smooth(2, image);
  EXPECT_NE(image.bins, noisy.bins);
  for (std::size_t i = 0; i < noisy.bins.size(); ++i)
    ASSERT_EQ(image.bins[i] >> 10, noisy.bins[i] >> 10);
  EXPECT_LT(chroma_noise(image, 3), 0.5 * chroma_noise(noisy, 3));
  BinImage none = noisy;
  smoother.smooth(0, none);
  EXPECT_EQ(none.bins, noisy.bins);
}

TEST(ChromaSmoother, ImagesSmallerThanItsSquare) {
  ChromaSmoother smoother;
  smoother.reserve(kWidth);
  for (const auto& [width, height] : {std::pair{1, 1}, {2, 5}, {9, 2}, {0, 0}}) {
    BinImage image;
    image.width = width;
    image.height = height;
    image.bins.assign(width * height, bin_of_rgb(200, 150, 120));
    const BinImage before = image;
    smoother.smooth(ChromaSmoother::kMaxRadius, image);
    EXPECT_EQ(image.bins, before.bins);
  }
}

}  // namespace
}  // namespace handyar
