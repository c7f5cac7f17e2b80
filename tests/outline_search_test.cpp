// SPDX-License-Identifier: MIT
#include "handyar/outline_search.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
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

/// Largest distance of a tip from the hand's, in thumb-little spans.
double tip_error(const HandShape& shape, const DrawnHand& hand, const View& view) {
  const HandModel model = average_adult_hand().for_layout(hand.layout);
  std::array<V, kFingerCount> truth;
  for (int f = 0; f < kFingerCount; ++f)
    truth[f] = view.image_hand() * model.tips_m.col(f).head<2>();
  double worst = 0;
  for (int f = 0; f < kFingerCount; ++f)
    worst = std::max(worst, (shape.tips[f].cast<double>() - truth[f]).norm());
  return worst / (truth[0] - truth[4]).norm();
}

/// Largest distance of a tip of the nearest proposal of the hand's layout, in thumb-little spans.
double nearest(std::span<const HandShape> proposals, const DrawnHand& hand, const View& view) {
  double best = 1e9;
  for (const HandShape& shape : proposals)
    if (shape.layout == hand.layout) best = std::min(best, tip_error(shape, hand, view));
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

/// A hand that is not the average one, as `view` shows it.
HandShape hand_in(const View& view, Layout layout) {
  HandShape hand = average_hand_shape();
  hand.tips[1] += Eigen::Vector2f(0.006f, 0.004f);
  hand.tips[3] += Eigen::Vector2f(-0.004f, -0.006f);
  hand.valleys[1] += Eigen::Vector2f(0.002f, -0.004f);
  const Eigen::Matrix<float, 2, 3> image_hand =
      view.image_hand().matrix().topRows<2>().cast<float>();
  return hand.laid(image_hand, layout);
}

/// A picture in noise of whatever `mask` covers, half of it darker, half lighter than the rest.
BinImage picture(const Mask& mask) {
  BinImage image{{kWidth, kHeight}, std::vector<ColorBin>(kWidth * kHeight)};
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, 3);
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) {
      const double gray = !mask.at(u, v) ? 128 : u + v < 290 ? 160 : 96;
      const int level = std::clamp(static_cast<int>(gray + noise(random)), 0, 255);
      image.bins[v * kWidth + u] = bin_of_rgb(level, level, level);
    }
  return image;
}

Mask silhouette(const HandShape& hand) {
  Mask mask;
  mask.reserve(kWidth * kHeight, kWidth);
  mask.resize(kWidth, kHeight);
  draw_silhouette(hand, mask);
  return mask;
}

constexpr float kThere = 0.66f;  // as AcquisitionConfig::sure_support

TEST(OutlineSearch, FollowsAHandWhereItMoves) {
  for (const Layout layout : {Layout::thumb_right, Layout::thumb_left}) {
    OutlineSearch search;
    search.reserve(kWidth * kHeight, kWidth);
    for (const View& view : {View{}, View{.middle_px = V(172, 112)}, View{.middle_px = V(150, 128)},
                             View{.roll = 0.15}, View{.px_per_m = 980}}) {
      const HandShape truth = hand_in(view, layout);
      HandShape now = hand_in({}, layout);
      EXPECT_GT(search.follow(picture(silhouette(truth)), now), kThere);
      EXPECT_EQ(now.layout, layout);
      for (int f = 0; f < kFingerCount; ++f)
        EXPECT_LT((now.tips[f] - truth.tips[f]).norm(), 0.35f * truth.finger_width) << f;
    }
  }
}

TEST(OutlineSearch, DoesNotFollowWhatIsNotThere) {
  OutlineSearch search;
  search.reserve(kWidth * kHeight, kWidth);
  const HandShape before = hand_in({}, Layout::thumb_right);
  HandShape folded = before;
  for (const int f : {0, 1}) folded.tips[f] = folded.finger_base(f) + Eigen::Vector2f(0, -2);
  Mask block = silhouette(before);
  block.resize(kWidth, kHeight);
  for (int v = 60; v < 200; ++v) block.set_run(v, 110, 210);
  for (const Mask& mask : {silhouette(folded), block,
                           silhouette(hand_in({.middle_px = V(160, 900)}, Layout::thumb_right))}) {
    HandShape now = before;
    EXPECT_LT(search.follow(picture(mask), now), 0.6f);
  }
}

TEST(OutlineSearch, AHandTooLargeForTheRoomIsNotFollowed) {
  OutlineSearch search;
  search.reserve(64 * 64, 64);
  HandShape hand = hand_in({}, Layout::thumb_right);
  EXPECT_EQ(search.follow(picture(silhouette(hand)), hand), 0);
}

TEST(Silhouette, EndsWhereTheOutlineDoes) {
  for (const Layout layout : {Layout::thumb_right, Layout::thumb_left}) {
    Eigen::Matrix<float, 2, 3> image_hand;
    image_hand << 900, 300, 150, 200, -700, 130;
    if (layout == Layout::thumb_left) image_hand.col(0) *= -1;
    const HandShape hand = average_hand_shape().laid(image_hand, layout);
    const Mask mask = silhouette(hand);
    HandOutline outline;
    outline.draw(hand.in_hand_plane());
    ASSERT_GT(outline.points().size(), 60u);
    constexpr float kPixel_m = 0.0015f;
    for (const HandOutline::Point& p : outline.points())
      for (const float out : {-kPixel_m, kPixel_m}) {
        if (p.bone >= kFingerCount) continue;  // which meet in corners
        const Eigen::Vector2f at = image_hand * (p.at_m + out * p.normal).homogeneous();
        EXPECT_EQ(mask.holds(at), out < 0) << p.bone << ": " << p.at_m.transpose();
      }
  }
}

TEST(Silhouette, OutsideThePictureIsLeftOut) {
  Eigen::Matrix<float, 2, 3> image_hand;
  image_hand << 900, 0, 0, 0, -900, 0;
  Mask mask;
  mask.reserve(50 * 40, 50);
  mask.resize(50, 40);
  draw_silhouette(average_hand_shape().laid(image_hand, Layout::thumb_right), mask);
  int set = 0;
  for (const std::uint64_t word : mask.words) set += std::popcount(word);
  int inside = 0;
  for (int v = 0; v < 40; ++v)
    for (int u = 0; u < 50; ++u) inside += mask.at(u, v);
  EXPECT_GT(inside, 500);
  EXPECT_EQ(set, inside);
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
