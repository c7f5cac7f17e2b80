// SPDX-License-Identifier: MIT
#include "handyar/color_histogram.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

#include "synthetic_hand.hpp"

namespace handyar {
namespace {

constexpr ColorBin bin(int luma, int yellowness, int redness) {
  return static_cast<ColorBin>(luma << 10 | yellowness << 5 | redness);
}

std::vector<float> smooth(const ColorHistogram& histogram, int times) {
  const BinSmoothing smoothing(times);
  std::vector<float> all;
  BinPlane plane;
  for (int luma = 0; luma < kBinLevels; ++luma) {
    histogram.smooth(smoothing, luma, plane);
    for (int row = 0; row < kBinLevels; ++row)
      all.insert(all.end(), plane.row(row).begin(), plane.row(row).end());
  }
  return all;
}

/// A picture of few colours.
std::vector<ColorBin> some_bins(const char* name) {
  std::mt19937 rng = test::random_for(name);
  std::normal_distribution<double> luma(15, 4), chroma(16, 2);
  std::vector<ColorBin> bins(500);
  for (ColorBin& b : bins) {
    const auto level = [&](auto& of) { return std::clamp(static_cast<int>(of(rng)), 0, 31); };
    b = bin(level(luma), level(chroma), level(chroma));
  }
  return bins;
}

TEST(ColorHistogram, SmoothingSpreadsEachChannelAndLosesNothing) {
  ColorHistogram histogram;
  const ColorBin inner = bin(10, 20, 6), corner = bin(0, 0, 0);
  histogram.add(inner, 64);
  histogram.add(corner, 64);
  const std::vector<float> smoothed = smooth(histogram, 1);
  EXPECT_FLOAT_EQ(smoothed[inner], 8);
  for (const int step : {1, 32, 1024}) {
    EXPECT_FLOAT_EQ(smoothed[inner + step], 4);
    EXPECT_FLOAT_EQ(smoothed[inner - step], 4);
  }
  EXPECT_FLOAT_EQ(smoothed[inner + 1 + 32 + 1024], 1);
  EXPECT_FLOAT_EQ(smoothed[corner], 48) << "coarse chroma stays, luma spreads";
  EXPECT_NEAR(std::accumulate(smoothed.begin(), smoothed.end(), 0.0), 128, 1e-3);
}

TEST(ColorHistogram, SmoothingTwiceIsSmoothingTheSmoothed) {
  ColorHistogram once, histogram;
  histogram.add(some_bins("SmoothingTwice"));
  const std::vector<float> first = smooth(histogram, 1);
  for (int i = 0; i < kBinCount; ++i) once.add(static_cast<ColorBin>(i), first[i]);
  const std::vector<float> again = smooth(once, 1), twice = smooth(histogram, 2);
  for (int i = 0; i < kBinCount; ++i) ASSERT_NEAR(again[i], twice[i], 1e-4) << "bin " << i;
}

TEST(ColorHistogram, AssignmentLeavesNothingOfWhatWasThere) {
  ColorHistogram one, other, expected;
  one.add(some_bins("one"));
  other.add(some_bins("other"));
  other.decay(0.5f);
  expected = other;
  one = other;
  EXPECT_EQ(one.total(), 250);
  EXPECT_EQ(one.filled(), expected.filled());
  for (int i = 0; i < kBinCount; ++i) {
    const auto b = static_cast<ColorBin>(i);
    ASSERT_EQ(one[b], expected[b]) << "bin " << i;
  }
}

TEST(ColorHistogram, WhatIsForgottenTakesNoRow) {
  ColorHistogram histogram;
  histogram.add(some_bins("forgotten"));
  for (int i = 0; i < 100; ++i) histogram.decay(0.8f);
  for (const std::uint32_t rows : histogram.filled()) EXPECT_EQ(rows, 0u);
  const std::vector<float> smoothed = smooth(histogram, 1);
  EXPECT_EQ(std::accumulate(smoothed.begin(), smoothed.end(), 0.0), 0);
}

}  // namespace
}  // namespace handyar
