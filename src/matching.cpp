// SPDX-License-Identifier: MIT
#include "handyar/matching.hpp"

#include <algorithm>
#include <limits>

namespace handyar {

TipAssignment match_tips(const std::array<Eigen::Vector2f, kFingerCount>& previous,
                         std::span<const Eigen::Vector2f> candidates, Layout layout,
                         float gate_px) noexcept {
  constexpr int kMax = CurvatureFinder::kMaxTips;
  const int n = std::min(static_cast<int>(candidates.size()), kMax);
  const float missing = gate_px * gate_px;
  // Clockwise with the thumb on the right the little finger comes first.
  const auto finger = [&](int place) {
    return layout == Layout::thumb_right ? kFingerCount - 1 - place : place;
  };

  TipAssignment best;
  best.fill(-1);
  float best_cost = kFingerCount * missing;
  for (int first = 0; first < n; ++first) {
    // cost[p][k]: least cost of the first p fingers using only the first k candidates from `first`.
    std::array<std::array<float, kMax + 1>, kFingerCount + 1> cost;
    for (int k = 0; k <= n; ++k) cost[0][k] = 0;
    for (int p = 1; p <= kFingerCount; ++p) {
      cost[p][0] = static_cast<float>(p) * missing;
      for (int k = 1; k <= n; ++k) {
        const Eigen::Vector2f& at = candidates[(first + k - 1) % n];
        const float d = (at - previous[finger(p - 1)]).squaredNorm();
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

}  // namespace handyar
