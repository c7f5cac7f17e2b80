// SPDX-License-Identifier: MIT
#include "handyar/hand_region.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "drawn_mask.hpp"
#include "synthetic_hand.hpp"

namespace handyar {
namespace {

using test::DrawnMask;

/// Components by flooding, the obvious way.
std::vector<Component> flood(const Mask& mask) {
  std::vector<Component> out;
  std::vector<char> done(mask.width * mask.height, 0);
  for (int v = 0; v < mask.height; ++v)
    for (int u = 0; u < mask.width; ++u) {
      if (!mask.at(u, v) || done[v * mask.width + u]) continue;
      Component c{0, 0, Eigen::Vector2f::Zero(), u, v, u, v, u};
      Eigen::Vector2d sum(0, 0);
      std::vector<std::pair<int, int>> open = {{u, v}};
      done[v * mask.width + u] = 1;
      while (!open.empty()) {
        const auto [x, y] = open.back();
        open.pop_back();
        ++c.area;
        sum += Eigen::Vector2d(x, y);
        c.u0 = std::min(c.u0, x);
        c.u1 = std::max(c.u1, x);
        c.v1 = std::max(c.v1, y);
        for (int dy = -1; dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx) {
            if (!mask.at(x + dx, y + dy) || done[(y + dy) * mask.width + x + dx]) continue;
            done[(y + dy) * mask.width + x + dx] = 1;
            open.push_back({x + dx, y + dy});
          }
      }
      c.centroid = (sum / c.area).cast<float>();
      out.push_back(c);
    }
  return out;
}

bool same(const Component& a, const Component& b) {
  return a.area == b.area && a.u0 == b.u0 && a.v0 == b.v0 && a.u1 == b.u1 && a.v1 == b.v1 &&
         a.first_u == b.first_u && (a.centroid - b.centroid).norm() < 1e-2f;
}

TEST(HandRegion, ComponentsAreThoseFoundByFlooding) {
  std::mt19937 rng = test::random_for("ComponentsAreThoseFoundByFlooding");
  for (const int percent : {10, 25, 40, 45, 60, 90})
    for (const auto& [w, h] : {std::pair{60, 45}, {33, 80}, {1, 50}, {50, 1}}) {
      DrawnMask drawn(w, h, [&](int, int) { return int(rng() % 100) < percent; });
      const std::vector<Component> expected = flood(drawn.region.mask());
      const auto found = drawn.region.components(4);
      const auto large =
          std::ranges::count_if(expected, [](const Component& c) { return c.area >= 4; });
      ASSERT_EQ(found.size(), std::min<std::size_t>(large, RegionFinder::kMaxComponents));
      for (std::size_t i = 0; i < found.size(); ++i) {
        EXPECT_TRUE(
            std::ranges::any_of(expected, [&](const Component& c) { return same(c, found[i]); }));
        EXPECT_LE(found[i].area, found[i > 0 ? i - 1 : 0].area);
      }
      // Whatever was left out is no larger than the least that was kept.
      const int least = found.empty() ? 0 : found.back().area;
      const auto above_least = [&](const Component& c) { return c.area > std::max(least, 3); };
      EXPECT_EQ(std::ranges::count_if(expected, above_least),
                std::ranges::count_if(found, above_least));
    }
}

TEST(HandRegion, AWideMaskOfOneComponent) {
  DrawnMask comb(600, 40, [](int u, int v) { return v == 39 || u % 2 == 0; });
  const auto found = comb.region.components(1);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].area, 300 * 40 + 300);
}

/// Ratios of the colours that `picture_of` uses: what is hand-like and what is not.
constexpr ColorBin kHand = 20 << 10 | 15 << 5 | 12, kWood = 24 << 10 | 15 << 5 | 12, kSky = 31;

BinImage picture_of(int width, int height, const auto& bin_at) {
  BinImage image;
  image.width = width;
  image.height = height;
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) image.bins.push_back(bin_at(u, v));
  return image;
}

std::vector<std::int8_t> hand_like(std::initializer_list<ColorBin> colors) {
  std::vector<std::int8_t> ratios(kBinCount, -32);
  for (const ColorBin c : colors) ratios[c] = 24;
  return ratios;
}

TEST(HandRegion, SmoothingIsTheMeanOfNineRatiosEdgesRepeatedAndThePlace) {
  constexpr int kWidth = 37, kHeight = 23;
  std::mt19937 rng = test::random_for("SmoothingIsTheMeanOfNineRatios");
  std::vector<std::int8_t> ratios(kBinCount);
  for (auto& r : ratios) r = static_cast<std::int8_t>(int(rng() % 255) - 127);
  const BinImage image = picture_of(
      kWidth, kHeight, [&](int, int) { return static_cast<ColorBin>(rng() % kBinCount); });
  RegionFinder region;
  region.reserve(kWidth * kHeight);
  ExpectedRegion inside;  // where edges do not count
  inside.ratios = {ExpectedRegion::kInside};
  region.classify(image, ratios, inside);
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) {
      int sum = 0;
      for (int y = v - 1; y <= v + 1; ++y)
        for (int x = u - 1; x <= u + 1; ++x)
          sum += ratios[image.bins[std::clamp(y, 0, kHeight - 1) * kWidth +
                                   std::clamp(x, 0, kWidth - 1)]];
      ASSERT_EQ(region.mask().at(u, v), sum > 0) << u << " " << v;
    }
}

TEST(HandRegion, ThePlaceDecidesWhereColourDoesNot) {
  const BinImage image = picture_of(40, 10, [](int, int) { return kHand; });
  RegionFinder region;
  region.reserve(400);
  ExpectedRegion expected;
  expected.cell = 10;
  expected.columns = 4;
  expected.ratios = {ExpectedRegion::kInside, 0, -25, ExpectedRegion::kOutside};
  region.classify(image, hand_like({kHand}), expected);
  EXPECT_TRUE(region.mask().at(5, 5));
  EXPECT_TRUE(region.mask().at(15, 5));
  EXPECT_FALSE(region.mask().at(25, 5));
  EXPECT_FALSE(region.mask().at(35, 5));
}

TEST(HandRegion, AnEdgeCutsWhatHasTheHandsColourAndTheBorderGrowsBack) {
  // A hand at the left, beside it wood that the skin model cannot tell from it, sky below.
  const BinImage image = picture_of(80, 40, [](int u, int v) {
    return v >= 30 ? kSky : u < 40 ? kHand : kWood;
  });
  const auto ratios = hand_like({kHand, kWood});
  RegionFinder region;
  region.reserve(80 * 40);
  region.classify(image, ratios, ExpectedRegion{});
  auto components = region.components(100);
  ASSERT_EQ(components.size(), 2u);
  region.keep_only(*region.component_at(10, 10));
  EXPECT_LT(region.components(100)[0].u1, 39);
  region.grow_back(3);
  components = region.components(100);
  ASSERT_EQ(components.size(), 1u);
  EXPECT_NEAR(components[0].u1, 40, 2);  // and no further into the wood
  EXPECT_NEAR(components[0].v1, 29, 1);  // the border to the sky is where it was
  // Expected inside the hand, an edge is a ring or a crease.
  ExpectedRegion inside;
  inside.ratios = {ExpectedRegion::kInside};
  region.classify(image, ratios, inside);
  EXPECT_EQ(region.components(100).size(), 1u);
}

TEST(HandRegion, AFingerThatARingCutsOffIsJoinedToItsHand) {
  constexpr int kFingerWidth = 12;
  const ExpectedHand::Finger finger{{40, 60}, {43, 12}}, away{{90, 60}, {90, 12}};  // a bit aslant
  const ExpectedHand expected{{40, 80}, kFingerWidth, {finger, away, away, away}};
  for (const int ring : {0, 3, 6, 16, 24}) {
    const BinImage image = picture_of(120, 100, [&](int u, int v) {
      const bool palm = v >= 62 && u >= 10 && u < 70;
      const bool in_finger = u >= 36 && u < 36 + kFingerWidth && v >= 10 && v < 62;
      const bool other = u >= 60 && u < 72 && v >= 10 && v < 40;  // of no finger that is expected
      return other || palm || (in_finger && (v < 46 || v >= 46 + ring)) ? kHand : kSky;
    });
    RegionFinder region;
    region.reserve(120 * 100);
    for (const bool by_place : {false, true}) {
      ExpectedRegion place;
      place.ratios = {by_place ? std::int8_t{0} : ExpectedRegion::kInside};
      ASSERT_NE(region.segment(image, hand_like({kHand}), place, expected, 200), nullptr);
      EXPECT_EQ(region.mask().holds({42, 20}), ring < kFingerWidth) << ring;
      EXPECT_FALSE(region.mask().holds({66, 20})) << ring;
      EXPECT_TRUE(region.mask().holds({40, 80}));
    }
  }
}

TEST(HandRegion, TheComponentAtAPointOrNearestToIt) {
  DrawnMask two(100, 60, [](int u, int v) {
    return (u >= 10 && u < 30 && v >= 10 && v < 50) || (u >= 60 && v >= 20 && v < 30);
  });
  ASSERT_EQ(two.region.components(1).size(), 2u);
  EXPECT_EQ(two.region.component_at(15, 12)->u0, 10);
  EXPECT_EQ(two.region.component_at(99, 25)->u0, 60);
  EXPECT_EQ(two.region.component_at(40, 25)->u0, 10);
  EXPECT_EQ(two.region.component_at(50, 25)->u0, 60);
  EXPECT_EQ(two.region.component_at(-500, 900)->u0, 10);
  two.region.components(500);  // now the smaller one does not count
  EXPECT_EQ(two.region.component_at(99, 25)->u0, 10);
  two.region.components(100000);
  EXPECT_EQ(two.region.component_at(15, 12), nullptr);
}

TEST(HandRegion, KeepOnlyClearsTheOthers) {
  const auto kept = [](int u, int v) { return u >= 10 && u < 30 && v >= 10 && v < 50; };
  DrawnMask many(100, 60, [&](int u, int v) { return kept(u, v) || (u > 40 && (u + v) % 5 < 2); });
  const auto found = many.region.components(1);
  const auto c = std::ranges::find_if(found, [](const Component& x) { return x.u0 == 10; });
  ASSERT_NE(c, found.end());
  many.region.keep_only(*c);
  for (int v = 0; v < 60; ++v)
    for (int u = 0; u < 100; ++u) ASSERT_EQ(many.region.mask().at(u, v), kept(u, v));
}

TEST(HandRegion, TheDeepestPointOfADiscIsItsCentre) {
  for (const double radius : {6.0, 20.0, 75.0, 200.0}) {
    const int size = static_cast<int>(2.5 * radius);
    const Eigen::Vector2d center(1.2 * radius + 0.3, 1.1 * radius + 0.4);
    DrawnMask disc(size, size,
                   [&](int u, int v) { return (Eigen::Vector2d(u, v) - center).norm() < radius; });
    ASSERT_TRUE(disc.trace_largest());
    const Disc deepest = disc.region.deepest(disc.largest);
    const double tolerance = 1.0 + 0.08 * radius;  // 3-4 chamfer distances, reduced resolution
    EXPECT_NEAR(deepest.radius, radius, tolerance);
    EXPECT_LT((deepest.center.cast<double>() - center).norm(), tolerance) << radius;
  }
}

TEST(HandRegion, TheDeepestPointOfARectangleLiesOnItsMiddleLine) {
  DrawnMask bar(300, 100, [](int u, int v) { return u >= 20 && u < 280 && v >= 30 && v < 80; });
  ASSERT_TRUE(bar.trace_largest());
  const Disc deepest = bar.region.deepest(bar.largest);
  EXPECT_NEAR(deepest.radius, 25, 4);
  EXPECT_NEAR(deepest.center.y(), 54.5, 4);
  EXPECT_GT(deepest.center.x(), 40);
  EXPECT_LT(deepest.center.x(), 260);
}

TEST(HandRegion, TheDeepestPointLiesInTheComponentAskedFor) {
  // A thin frame of large area around a disc that is no part of it.
  const auto in_disc = [](int u, int v) { return std::hypot(u - 100, v - 100) < 40; };
  DrawnMask drawn(200, 200, [&](int u, int v) {
    return in_disc(u, v) || std::min({u, v, 199 - u, 199 - v}) < 12;
  });
  ASSERT_TRUE(drawn.trace_largest());
  ASSERT_EQ(drawn.largest.u0, 0);
  const Disc deepest = drawn.region.deepest(drawn.largest);
  EXPECT_FALSE(in_disc(int(deepest.center.x()), int(deepest.center.y())));
  EXPECT_LT(deepest.radius, 12);
}

}  // namespace
}  // namespace handyar
