// SPDX-License-Identifier: MIT
#include "handyar/skin_model.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "synthetic_hand.hpp"

namespace handyar {
namespace {

struct Rgb {
  int r, g, b;
};
std::ostream& operator<<(std::ostream& out, const Rgb& c) {
  return out << "RGB " << c.r << " " << c.g << " " << c.b;
}

constexpr Rgb kSkin[] = {{236, 188, 160}, {220, 160, 130}, {198, 140, 110},
                         {170, 110, 80},  {140, 88, 62},   {110, 70, 50}};
constexpr Rgb kOther[] = {{30, 60, 200}, {40, 160, 60}, {90, 140, 220},
                          {0, 130, 130}, {60, 60, 160}, {250, 250, 250}};

int level(double c) { return std::clamp(static_cast<int>(c), 0, 255) / 8; }

ColorBin rgb_bin(const Rgb& c) {
  return static_cast<ColorBin>(level(c.r) << 10 | level(c.g) << 5 | level(c.b));
}

/// As a camera codes it: BT.601, video range.
ColorBin ycbcr_bin(const Rgb& c) {
  const double y = 16 + (65.74 * c.r + 129.06 * c.g + 25.06 * c.b) / 256;
  const double cb = 128 + (-37.95 * c.r - 74.49 * c.g + 112.44 * c.b) / 256;
  const double cr = 128 + (112.44 * c.r - 94.15 * c.g - 18.29 * c.b) / 256;
  return static_cast<ColorBin>(level(y) << 10 | level(cb) << 5 | level(cr));
}

ColorBin bin(const Rgb& c, ColorSpace space) {
  return space == ColorSpace::rgb ? rgb_bin(c) : ycbcr_bin(c);
}

/// Bins of a surface of one colour seen with noise.
std::vector<ColorBin> surface(const Rgb& c, ColorSpace space, const std::string& name,
                              int count = 2000) {
  std::mt19937 rng = test::random_for(name);
  std::vector<ColorBin> bins(count);
  for (ColorBin& b : bins)
    b = bin({c.r + int(test::gauss(rng, 8)), c.g + int(test::gauss(rng, 8)),
             c.b + int(test::gauss(rng, 8))},
            space);
  return bins;
}

class SkinModelIn : public testing::TestWithParam<ColorSpace> {
 protected:
  SkinModelIn() { model.reset(GetParam()); }
  int ratio(const Rgb& c) const { return model.ratios()[bin(c, GetParam())]; }
  std::vector<ColorBin> seen(const Rgb& c, const std::string& name) const {
    return surface(c, GetParam(), name);
  }
  SkinModel model;
};

TEST_P(SkinModelIn, ThePriorTellsSkinFromBlueAndGreen) {
  for (const Rgb& c : kSkin) EXPECT_GT(ratio(c), 0) << c;
  for (const Rgb& c : kOther) EXPECT_LT(ratio(c), 0) << c;
  EXPECT_FALSE(model.has_learned());
}

TEST_P(SkinModelIn, LearnsABlueGlove) {
  const Rgb glove{40, 70, 190}, wall{198, 150, 120};
  ASSERT_LT(ratio(glove), 0);
  ASSERT_GT(ratio(wall), 0);
  for (int i = 0; i < 5; ++i) model.learn(seen(glove, "glove"), seen(wall, "wall"));
  EXPECT_TRUE(model.has_learned());
  EXPECT_GT(ratio(glove), 8);
  EXPECT_LT(ratio(wall), -8);
}

TEST_P(SkinModelIn, OneFrameIsEnoughToBegin) {
  const Rgb glove{40, 70, 190};
  model.learn(seen(glove, "glove"), seen({128, 128, 128}, "wall"));
  EXPECT_GT(ratio(glove), 0);
}

TEST_P(SkinModelIn, FollowsALightThatChanges) {
  const Rgb before{230, 180, 150}, after{90, 60, 110}, wall{128, 128, 128};
  for (int i = 0; i < 30; ++i) model.learn(seen(before, "before"), seen(wall, "wall"));
  EXPECT_LT(ratio(after), 0);
  for (int i = 0; i < 10; ++i) model.learn(seen(after, "after"), seen(wall, "wall"));
  EXPECT_GT(ratio(after), 8);
}

TEST_P(SkinModelIn, WhatWasLearnedStaysAndResetForgetsIt) {
  const SkinModel::Ratios prior = model.ratios();
  for (int i = 0; i < 5; ++i)
    model.learn(seen({40, 70, 190}, "glove"), seen({128, 128, 128}, "wall"));
  const SkinModel::Ratios learned = model.ratios();
  const SkinModel copy = model;  // the tracker keeps one while it tries another
  model.learn({}, {});
  int farthest = 0;
  for (int i = 0; i < kBinCount; ++i)
    farthest = std::max(farthest, std::abs(model.ratios()[i] - learned[i]));
  EXPECT_LE(farthest, 1) << "a frame that shows nothing teaches nothing";
  EXPECT_EQ(copy.ratios(), learned);
  model.reset(GetParam());
  EXPECT_FALSE(model.has_learned());
  EXPECT_EQ(model.ratios(), prior);
}

TEST_P(SkinModelIn, AColourNeverSeenKeepsThePriorsOpinion) {
  for (int i = 0; i < 5; ++i)
    model.learn(seen({200, 145, 115}, "hand"), seen({128, 128, 128}, "wall"));
  EXPECT_LT(ratio({40, 70, 190}), 0);
  EXPECT_LT(ratio({40, 160, 60}), 0);
}

TEST_P(SkinModelIn, GivesBackWhatItLearnedAsRgb) {
  EXPECT_TRUE(model.learned_colors().empty());
  for (int i = 0; i < 5; ++i)
    model.learn(seen({40, 70, 190}, "glove"), seen({198, 150, 120}, "wall"));
  double total = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const SkinColors::Entry& e : model.learned_colors().entries) {
    EXPECT_GT(e.share, 0);
    total += e.share;
    mean += e.share * rgb_of(e.rgb_bin, ColorSpace::rgb);
  }
  EXPECT_NEAR(total, 1, 1e-4);
  EXPECT_LT((mean - Eigen::Vector3d(40, 70, 190)).cwiseAbs().maxCoeff(), 5) << mean.transpose();
}

TEST_P(SkinModelIn, PersonalColoursTakeThePriorsPlaceInEitherSpace) {
  const Rgb glove{40, 70, 190};
  for (const ColorSpace learned_in : {ColorSpace::rgb, ColorSpace::ycbcr}) {
    SkinModel teacher;
    teacher.reset(learned_in);
    teacher.learn(surface(glove, learned_in, "glove"),
                  surface({128, 128, 128}, learned_in, "wall"));
    SkinModelConfig config;
    config.personal = teacher.learned_colors();
    model = SkinModel(config);
    model.reset(GetParam());
    EXPECT_FALSE(model.has_learned());
    EXPECT_GT(ratio(glove), 16);
    EXPECT_GT(ratio({50, 85, 210}), 0) << "the same glove in a little more light";
    for (const Rgb& c : kSkin) EXPECT_LT(ratio(c), 0) << c;
    double total = 0;
    for (const std::uint8_t x : model.prior_skin()) total += x == 255 ? 0 : std::exp(-x / 8.0);
    // A bin of YCbCr has 6.38 times the volume of one of RGB, and the prior is the middle's.
    EXPECT_NEAR(total, GetParam() == ColorSpace::rgb ? 1 : 1 / 6.38, 0.03);
  }
}

INSTANTIATE_TEST_SUITE_P(Spaces, SkinModelIn, testing::Values(ColorSpace::rgb, ColorSpace::ycbcr));

TEST(SkinModel, ThePriorsAreProbabilitiesOverTheBins) {
  const SkinModel model;
  for (const auto& prior : {model.prior_skin(), model.prior_other()}) {
    ASSERT_EQ(prior.size(), std::size_t(kBinCount));
    double total = 0;
    for (const std::uint8_t x : prior) total += std::exp(-x / 8.0);
    EXPECT_NEAR(total, 1, 0.03);
  }
}

TEST(SkinModel, TheSpacesAgreeOnTypicalColours) {
  SkinModel rgb, ycbcr;
  ycbcr.reset(ColorSpace::ycbcr);
  for (const Rgb& c : kSkin)
    EXPECT_NEAR(rgb.ratios()[rgb_bin(c)], ycbcr.ratios()[ycbcr_bin(c)], 11) << c;
}

TEST(SkinModel, SmoothingSpreadsEachChannelAndLosesNothing) {
  std::vector<float> count(kBinCount), scratch(kBinCount), smooth(kBinCount);
  const int inner = 10 << 10 | 20 << 5 | 5, corner = 0;
  count[inner] = 64;
  count[corner] = 64;
  smooth_histogram(count, scratch, smooth);
  EXPECT_FLOAT_EQ(smooth[inner], 8);
  for (const int step : {1, 32, 1024}) {
    EXPECT_FLOAT_EQ(smooth[inner + step], 4);
    EXPECT_FLOAT_EQ(smooth[inner - step], 4);
  }
  EXPECT_FLOAT_EQ(smooth[inner + 1 + 32 + 1024], 1);
  EXPECT_FLOAT_EQ(smooth[corner], 27);
  EXPECT_NEAR(std::accumulate(smooth.begin(), smooth.end(), 0.0), 128, 1e-3);
}

}  // namespace
}  // namespace handyar
