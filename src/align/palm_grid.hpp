// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>

#include "handyar/stages/hand_figure.hpp"

namespace handyar {

/// A number for each cell of a grid on the palm, row by row from the wrist to the fingers.
inline constexpr int kPalmSide = 20, kPalmCells = kPalmSide * kPalmSide;
using PalmField = std::array<float, kPalmCells>;

/// The visible face of the palm: a grid between wrist and roots of the fingers, at the height of
/// the figure's sheets. Places in the hand frame, metres.
std::array<PalmField, 3> palm_surface(const HandFigure& figure) noexcept;

/// Means over so many neighbours on all sides; beyond the grid it goes on as it ends.
template <int kReach>
PalmField smoothed(const PalmField& in) noexcept {
  constexpr int kWide = kPalmSide + 2 * kReach;
  std::array<float, kPalmSide * kWide> sums{};
  const auto row = [&](int v) { return in.data() + std::clamp(v, 0, kPalmSide - 1) * kPalmSide; };
  for (int v = 0; v < kPalmSide; ++v) {
    float* const sum = sums.data() + v * kWide + kReach;
    for (int k = -kReach; k <= kReach; ++k) {
      const float* const from = row(v + k);
      for (int u = 0; u < kPalmSide; ++u) sum[u] += from[u];
    }
    for (int k = 1; k <= kReach; ++k) {
      sum[-k] = sum[0];
      sum[kPalmSide - 1 + k] = sum[kPalmSide - 1];
    }
  }
  PalmField out{};
  constexpr float kCount = (2 * kReach + 1) * (2 * kReach + 1);
  for (int v = 0; v < kPalmSide; ++v) {
    float* const to = out.data() + v * kPalmSide;
    for (int k = 0; k <= 2 * kReach; ++k) {
      const float* const from = sums.data() + v * kWide + k;
      for (int u = 0; u < kPalmSide; ++u) to[u] += from[u];
    }
    for (int u = 0; u < kPalmSide; ++u) to[u] /= kCount;
  }
  return out;
}

}  // namespace handyar
