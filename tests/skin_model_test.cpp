// SPDX-License-Identifier: MIT
#include "handyar/skin_model.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

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

ColorBin bin(const Rgb& c) {
  const auto level = [](int x) { return std::clamp(x, 0, 255); };
  return bin_of_rgb(level(c.r), level(c.g), level(c.b));
}

/// Bins of a surface of one colour seen with noise.
std::vector<ColorBin> seen(const Rgb& c, const std::string& name) {
  std::mt19937 rng = test::random_for(name);
  std::vector<ColorBin> bins(2000);
  for (ColorBin& b : bins)
    b = bin({c.r + int(test::gauss(rng, 8)), c.g + int(test::gauss(rng, 8)),
             c.b + int(test::gauss(rng, 8))});
  return bins;
}

int ratio(const SkinModel& model, const Rgb& c) { return model.ratios()[bin(c)]; }

TEST(SkinModel, ThePriorTellsSkinFromBlueAndGreen) {
  SkinModel model;
  for (const Rgb& c : kSkin) EXPECT_GT(ratio(model, c), 0) << c;
  for (const Rgb& c : kOther) EXPECT_LT(ratio(model, c), 0) << c;
  EXPECT_FALSE(model.has_learned());
}

TEST(SkinModel, LearnsABlueGlove) {
  SkinModel model;
  const Rgb glove{40, 70, 190}, wall{198, 150, 120};
  ASSERT_LT(ratio(model, glove), 0);
  ASSERT_GT(ratio(model, wall), 0);
  for (int i = 0; i < 5; ++i) model.learn(seen(glove, "glove"), seen(wall, "wall"));
  EXPECT_TRUE(model.has_learned());
  EXPECT_GT(ratio(model, glove), 8);
  EXPECT_LT(ratio(model, wall), -8);
}

TEST(SkinModel, OneFrameIsEnoughToBegin) {
  SkinModel model;
  const Rgb glove{40, 70, 190};
  model.learn(seen(glove, "glove"), seen({128, 128, 128}, "wall"));
  EXPECT_GT(ratio(model, glove), 0);
}

TEST(SkinModel, FollowsALightThatChanges) {
  SkinModel model;
  const Rgb before{230, 180, 150}, after{90, 60, 110}, wall{128, 128, 128};
  for (int i = 0; i < 30; ++i) model.learn(seen(before, "before"), seen(wall, "wall"));
  EXPECT_LT(ratio(model, after), 0);
  for (int i = 0; i < 10; ++i) model.learn(seen(after, "after"), seen(wall, "wall"));
  EXPECT_GT(ratio(model, after), 8);
}

TEST(SkinModel, WhatWasLearnedStaysAndResetForgetsIt) {
  SkinModel model;
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
  model.reset();
  EXPECT_FALSE(model.has_learned());
  EXPECT_EQ(model.ratios(), prior);
}

TEST(SkinModel, AColourNeverSeenKeepsThePriorsOpinion) {
  SkinModel model;
  for (int i = 0; i < 5; ++i)
    model.learn(seen({200, 145, 115}, "hand"), seen({128, 128, 128}, "wall"));
  EXPECT_LT(ratio(model, {40, 70, 190}), 0);
  EXPECT_LT(ratio(model, {40, 160, 60}), 0);
}

TEST(SkinModel, GivesBackTheColoursThatItLearned) {
  SkinModel model;
  EXPECT_TRUE(model.learned_colors().empty());
  for (int i = 0; i < 5; ++i)
    model.learn(seen({160, 110, 90}, "glove"), seen({198, 150, 120}, "wall"));
  double total = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const SkinColors::Entry& e : model.learned_colors().entries) {
    EXPECT_GT(e.share, 0);
    total += e.share;
    mean += e.share * rgb_of(e.bin);
  }
  EXPECT_NEAR(total, 1, 1e-4);
  EXPECT_LT((mean - Eigen::Vector3d(160, 110, 90)).cwiseAbs().maxCoeff(), 5) << mean.transpose();
}

TEST(SkinModel, PersonalColoursTakeThePriorsPlace) {
  const Rgb glove{40, 70, 190};
  SkinModel teacher;
  teacher.learn(seen(glove, "glove"), seen({128, 128, 128}, "wall"));
  SkinModelConfig config;
  config.personal = teacher.learned_colors();
  const SkinModel model(config);
  EXPECT_FALSE(model.has_learned());
  EXPECT_GT(ratio(model, glove), 16);
  EXPECT_GT(ratio(model, {50, 85, 210}), 0) << "the same glove in a little more light";
  for (const Rgb& c : kSkin) EXPECT_LT(ratio(model, c), 0) << c;
  double total = 0;
  for (const std::uint8_t x : model.prior_skin()) total += x == 255 ? 0 : std::exp(-x / 8.0);
  EXPECT_NEAR(total, 1, 0.03);
}

TEST(SkinModel, ANewlyFoundHandStandsForMoreColoursThanOneThatIsTracked) {
  const Rgb hand{110, 120, 90}, wall{128, 128, 128};
  SkinModel sure, found;
  found.widen();
  sure.learn(seen(hand, "hand"), seen(wall, "wall"));
  found.learn(seen(hand, "hand"), seen(wall, "wall"));
  const auto hand_like = [](const SkinModel& m) {
    return std::ranges::count_if(m.ratios(), [](int r) { return r > 0; });
  };
  EXPECT_GT(hand_like(found), 1.1 * hand_like(sure));
  EXPECT_LT(ratio(found, wall), 0);
  for (int i = 0; i < 20; ++i)
    for (SkinModel* m : {&sure, &found}) m->learn(seen(hand, "hand"), seen(wall, "wall"));
  EXPECT_EQ(found.ratios(), sure.ratios()) << "it narrows with each frame";
}

TEST(SkinModel, ThePriorsAreProbabilitiesOverTheBins) {
  const SkinModel model;
  for (const auto& prior : {model.prior_skin(), model.prior_other()}) {
    ASSERT_EQ(prior.size(), std::size_t(kBinCount));
    double total = 0;
    for (const std::uint8_t x : prior) total += std::exp(-x / 8.0);
    EXPECT_NEAR(total, 1, 0.03);
  }
}

}  // namespace
}  // namespace handyar
