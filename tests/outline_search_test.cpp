// SPDX-License-Identifier: MIT
#include "handyar/outline_search.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <random>

#include "drawn_hand.hpp"

namespace handyar {
namespace {

using test::DrawnHand;
using V = Eigen::Vector2d;

constexpr int kWidth = 320, kHeight = 240;

struct View {
  double px_per_m = 900;
  double roll = 0;
  V middle_px{160, 120};

  Eigen::Affine2d image_hand() const {
    Eigen::Affine2d view = Eigen::Affine2d::Identity();
    view.linear() =
        px_per_m * Eigen::Rotation2Dd(roll).toRotationMatrix() * Eigen::Scaling(1.0, -1.0);
    view.translation() = middle_px - view.linear() * V(0, -0.01);
    return view;
  }
};

/// A grey picture of the hand, in noise: what lies left of a line through it is darker than the
/// background, what lies right of it lighter, so that no threshold tells it from the background.
BinImage picture(const DrawnHand& hand, const View& view) {
  BinImage image;
  image.width = kWidth;
  image.height = kHeight;
  image.bins.resize(kWidth * kHeight);
  const Eigen::Affine2d hand_px = view.image_hand().inverse();
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, 3);
  const auto distance_m = hand.distance_m();
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) {
      const V p = hand_px * V(u, v);
      const bool lit = p.x() + 0.4 * p.y() > 0;
      const double gray = distance_m(p.x(), p.y()) > 0 ? 128 : lit ? 160 : 96;
      const int level = std::clamp(static_cast<int>(gray + noise(random)), 0, 255);
      image.bins[v * kWidth + u] = bin_of_rgb(level, level, level);
    }
  return image;
}

/// Largest distance of a tip of the nearest proposal of the hand's layout, in thumb-little spans.
double nearest(std::span<const HandShape> proposals, const DrawnHand& hand, const View& view) {
  const HandModel model = average_adult_hand().for_layout(hand.layout);
  std::array<V, kFingerCount> truth;
  for (int f = 0; f < kFingerCount; ++f)
    truth[f] = view.image_hand() * model.tips_m.col(f).head<2>();
  double best = 1e9;
  for (const HandShape& shape : proposals) {
    double worst = 0;
    for (int f = 0; f < kFingerCount; ++f)
      worst = std::max(worst, (shape.tips[f].cast<double>() - truth[f]).norm());
    if (shape.layout == hand.layout) best = std::min(best, worst / (truth[0] - truth[4]).norm());
  }
  return best;
}

/// The nearest proposal once every direction had its turn.
double nearest_in_a_round(const DrawnHand& hand, const View& view) {
  const OutlineSearchConfig config;
  OutlineSearch search(config);
  search.reserve(kWidth * kHeight, kWidth);
  const BinImage image = picture(hand, view);
  double best = 1e9;
  for (int turn = 0; turn < 30 / config.directions_per_frame; ++turn)
    best = std::min(best, nearest(search.find(image), hand, view));
  return best;
}

constexpr double kNear = 0.15;

TEST(OutlineSearch, FindsAHandThatNoThresholdCutsOut) {
  for (const Layout layout : {Layout::thumb_right, Layout::thumb_left})
    EXPECT_LT(nearest_in_a_round({.layout = layout}, {}), kNear) << int(layout);
}

TEST(OutlineSearch, FindsItPointingAnywhere) {
  for (const double roll : {-150.0, -100.0, -47.0, 33.0, 90.0, 180.0})
    EXPECT_LT(nearest_in_a_round({}, {.roll = roll * std::numbers::pi / 180}), kNear) << roll;
}

TEST(OutlineSearch, FindsItAtEverySize) {
  for (const double px_per_m : {450.0, 600.0, 800.0, 1000.0})
    EXPECT_LT(nearest_in_a_round({}, {.px_per_m = px_per_m}), kNear) << px_per_m;
}

TEST(OutlineSearch, FindsItWhereverItIs) {
  for (const V& middle : {V(90, 90), V(230, 100), V(100, 160), V(225, 165)})
    EXPECT_LT(nearest_in_a_round({}, {.px_per_m = 700, .middle_px = middle}), kNear)
        << middle.transpose();
}

TEST(OutlineSearch, ProposalsLieApartAndAreNoMoreThanAskedFor) {
  OutlineSearch search({.directions_per_frame = 30, .proposals = 4});
  search.reserve(kWidth * kHeight, kWidth);
  const auto proposals = search.find(picture({}, {}));
  EXPECT_LE(proposals.size(), 4u);
  OutlineSearch none({.proposals = 0});
  none.reserve(kWidth * kHeight, kWidth);
  EXPECT_TRUE(none.find(picture({}, {})).empty());
}

TEST(OutlineSearch, TinyAndPlainPicturesDoNoHarm) {
  OutlineSearch search;
  search.reserve(kWidth * kHeight, kWidth);
  BinImage image;
  image.bins.resize(kWidth * kHeight);
  for (const auto& [width, height] : {std::pair{0, 0}, {1, 1}, {59, 320}, {60, 60}, {320, 240}}) {
    image.width = width;
    image.height = height;
    for (const HandShape& shape : search.find(image))
      for (const auto& tip : shape.tips) EXPECT_TRUE(tip.allFinite());
  }
}

}  // namespace
}  // namespace handyar
