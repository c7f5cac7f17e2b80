// SPDX-License-Identifier: MIT
#include "handyar/matching.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "synthetic_hand.hpp"

namespace handyar {
namespace {

using Positions = std::array<Eigen::Vector2f, kFingerCount>;

/// Tips of a thumb_right hand around its centroid, pixels, fingers up on the screen.
Positions tips_of(Layout layout) {
  Positions p = {{{95, 30}, {45, -50}, {0, -65}, {-42, -48}, {-72, -10}}};
  if (layout == Layout::thumb_left)
    for (auto& tip : p) tip.x() = -tip.x();
  return p;
}

/// Candidates in clockwise order: the little finger first where the thumb is on the right.
std::vector<Eigen::Vector2f> clockwise(const Positions& tips, Layout layout) {
  std::vector<Eigen::Vector2f> c(tips.begin(), tips.end());
  if (layout == Layout::thumb_right) std::ranges::reverse(c);
  return c;
}

constexpr float kGate = 50;
constexpr Layout kLayouts[] = {Layout::thumb_right, Layout::thumb_left};

TEST(Matching, EveryFingerInEitherLayoutWhereverTheContourBegins) {
  for (const Layout layout : kLayouts) {
    const Positions previous = tips_of(layout);
    Positions now = previous;
    for (auto& p : now) p += Eigen::Vector2f(8, -5);
    std::vector<Eigen::Vector2f> candidates = clockwise(now, layout);
    for (int turn = 0; turn < kFingerCount; ++turn) {
      const TipAssignment a = match_tips(previous, candidates, layout, kGate);
      for (int f = 0; f < kFingerCount; ++f) {
        ASSERT_GE(a[f], 0);
        EXPECT_EQ(candidates[a[f]], now[f]) << name(layout) << " " << kFingerNames[f];
      }
      std::rotate(candidates.begin(), candidates.begin() + 1, candidates.end());
    }
  }
}

TEST(Matching, AMissingTipIsMissingAndTheOthersKeepTheirNames) {
  for (const Layout layout : kLayouts)
    for (int hidden = 0; hidden < kFingerCount; ++hidden) {
      const Positions tips = tips_of(layout);
      std::vector<Eigen::Vector2f> candidates;
      for (const auto& c : clockwise(tips, layout))
        if (c != tips[hidden]) candidates.push_back(c + Eigen::Vector2f(-6, 3));
      const TipAssignment a = match_tips(tips, candidates, layout, kGate);
      for (int f = 0; f < kFingerCount; ++f) {
        if (f == hidden) {
          EXPECT_EQ(a[f], -1);
        } else {
          ASSERT_GE(a[f], 0);
          EXPECT_LT((candidates[a[f]] - tips[f]).norm(), 10) << kFingerNames[f];
        }
      }
    }
}

TEST(Matching, AnExtraTipIsLeftOut) {
  const Positions tips = tips_of(Layout::thumb_right);
  std::vector<Eigen::Vector2f> candidates = clockwise(tips, Layout::thumb_right);
  const Eigen::Vector2f extra(-20, -62);  // between middle and ring
  candidates.insert(candidates.begin() + 2, extra);
  const TipAssignment a = match_tips(tips, candidates, Layout::thumb_right, kGate);
  for (int f = 0; f < kFingerCount; ++f) {
    ASSERT_GE(a[f], 0);
    EXPECT_EQ(candidates[a[f]], tips[f]);
  }
}

TEST(Matching, TheOrderAlongTheContourIsKept) {
  // Index and middle have crossed on the screen: nearest neighbours would name them the other way.
  const Positions tips = tips_of(Layout::thumb_right);
  Positions crossed = tips;
  std::swap(crossed[1], crossed[2]);
  const auto candidates = clockwise(tips, Layout::thumb_right);
  const TipAssignment a = match_tips(crossed, candidates, Layout::thumb_right, 1000);
  for (int f = 0; f < kFingerCount; ++f) EXPECT_EQ(a[f], kFingerCount - 1 - f);
}

TEST(Matching, NothingWithinTheGateIsNoMatch) {
  const Positions tips = tips_of(Layout::thumb_right);
  auto candidates = clockwise(tips, Layout::thumb_right);
  for (auto& c : candidates) c += Eigen::Vector2f(0, 300);
  for (const int index : match_tips(tips, candidates, Layout::thumb_right, kGate))
    EXPECT_EQ(index, -1);
  for (const int index : match_tips(tips, {}, Layout::thumb_right, kGate)) EXPECT_EQ(index, -1);
}

/// Whether the candidates of the fingers found run clockwise from the little finger to the thumb
/// (thumb_right), each used once.
bool in_order(const TipAssignment& a, Layout layout) {
  std::vector<int> found;
  for (int f = 0; f < kFingerCount; ++f)
    if (a[f] >= 0) found.push_back(a[f]);
  if (layout == Layout::thumb_right) std::ranges::reverse(found);
  int descents = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const int next = found[(i + 1) % found.size()];
    if (found.size() > 1 && next == found[i]) return false;
    descents += next < found[i];
  }
  return descents <= 1;
}

double cost_of(const TipAssignment& a, const Positions& previous,
               const std::vector<Eigen::Vector2f>& candidates) {
  double cost = 0;
  for (int f = 0; f < kFingerCount; ++f)
    cost += a[f] < 0 ? kGate * kGate : (candidates[a[f]] - previous[f]).squaredNorm();
  return cost;
}

TEST(Matching, NoOtherAssignmentInOrderCostsLess) {
  std::mt19937 rng = test::random_for("NoOtherAssignmentInOrderCostsLess");
  for (int trial = 0; trial < 60; ++trial) {
    const Layout layout = kLayouts[trial % 2];
    const Positions previous = tips_of(layout);
    const int n = 1 + trial % 7;
    std::vector<Eigen::Vector2f> candidates(n);
    for (auto& c : candidates)
      c = previous[rng() % kFingerCount] +
          Eigen::Vector2f(float(test::gauss(rng, 30)), float(test::gauss(rng, 30)));
    const TipAssignment found = match_tips(previous, candidates, layout, kGate);
    ASSERT_TRUE(in_order(found, layout));
    double least = 1e30;
    TipAssignment a;
    const auto enumerate = [&](auto&& self, int f) -> void {
      if (f == kFingerCount) {
        if (in_order(a, layout)) least = std::min(least, cost_of(a, previous, candidates));
        return;
      }
      for (a[f] = -1; a[f] < n; ++a[f]) self(self, f + 1);
    };
    enumerate(enumerate, 0);
    EXPECT_NEAR(cost_of(found, previous, candidates), least, 0.1) << "trial " << trial;
  }
}

}  // namespace
}  // namespace handyar
