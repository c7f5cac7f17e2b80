// SPDX-License-Identifier: MIT
#include "paper/matching.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace handyar::paper {

std::optional<OrderedTips> order_tips(std::span<const Fingertip> tips,
                                      const Eigen::Vector2f& palm) noexcept {
  if (tips.size() != kFingerCount) return std::nullopt;
  // Around the palm the fingers form a fan: it begins after the widest gap.
  std::array<float, kFingerCount> angle;
  Eigen::Vector2f mean = Eigen::Vector2f::Zero();
  for (int i = 0; i < kFingerCount; ++i) {
    const Eigen::Vector2f d = tips[i].at - palm;
    angle[i] = std::atan2(d.y(), d.x());
    mean += tips[i].at / kFingerCount;
  }
  int first = 0;
  float widest = -1;
  for (int i = 0; i < kFingerCount; ++i) {
    constexpr auto kTurn = 2 * std::numbers::pi_v<float>;
    float gap = angle[i] - angle[(i + kFingerCount - 1) % kFingerCount];
    gap -= kTurn * std::floor(gap / kTurn);
    if (gap <= widest) continue;
    widest = gap;
    first = i;
  }
  const int last = (first + kFingerCount - 1) % kFingerCount;
  const bool thumb_first = (tips[first].at - mean).norm() > (tips[last].at - mean).norm();
  OrderedTips ordered;
  for (int k = 0; k < kFingerCount; ++k)
    ordered.at[thumb_first ? k : kFingerCount - 1 - k] = tips[(first + k) % kFingerCount].at;
  // The contour runs clockwise: from the left, over the top.
  ordered.layout = thumb_first ? Layout::thumb_left : Layout::thumb_right;
  return ordered;
}

TipAssignment match_tips(const OrderedTips& previous, std::span<const Fingertip> candidates,
                         float gate) noexcept {
  constexpr int kMost = FingertipFinder::kMostTips;
  const int n = std::min(static_cast<int>(candidates.size()), kMost);
  const float missing = gate * gate;
  // Clockwise with the thumb on the right the little finger comes first.
  const auto finger = [&](int place) {
    return previous.layout == Layout::thumb_right ? kFingerCount - 1 - place : place;
  };
  TipAssignment best;
  best.fill(-1);
  float best_cost = kFingerCount * missing;
  for (int first = 0; first < n; ++first) {
    // cost[p][k]: least cost of the first p fingers by the first k candidates from `first` on.
    std::array<std::array<float, kMost + 1>, kFingerCount + 1> cost{};
    for (int p = 1; p <= kFingerCount; ++p) {
      cost[p][0] = static_cast<float>(p) * missing;
      for (int k = 1; k <= n; ++k) {
        const Eigen::Vector2f& at = candidates[(first + k - 1) % n].at;
        const float d = (at - previous.at[finger(p - 1)]).squaredNorm();
        cost[p][k] = std::min({cost[p][k - 1], cost[p - 1][k] + missing, cost[p - 1][k - 1] + d});
      }
    }
    if (!(cost[kFingerCount][n] < best_cost)) continue;
    best_cost = cost[kFingerCount][n];
    best.fill(-1);
    for (int p = kFingerCount, k = n; p > 0 && k > 0;) {
      if (cost[p][k] == cost[p][k - 1]) {
        --k;
      } else if (cost[p][k] == cost[p - 1][k] + missing) {
        --p;
      } else {
        best[finger(p - 1)] = (first + k - 1) % n;
        --p;
        --k;
      }
    }
  }
  return best;
}

}  // namespace handyar::paper
