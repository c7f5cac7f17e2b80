// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <span>

#include "find/network.hpp"

namespace handyar {

/// Maps of a run of the network, cell by cell.
class FinderMaps {
 public:
  static constexpr int kWidth = FinderNetwork::kCellsX, kHeight = FinderNetwork::kCellsY;

  explicit FinderMaps(std::span<const float> numbers) : numbers_(numbers) {}

  bool covers(int x, int y) const { return x >= 0 && y >= 0 && x < kWidth && y < kHeight; }
  float at(int map, int x, int y) const {
    return numbers_[(y * kWidth + x) * FinderNetwork::kOutputs + map];
  }

  /// The largest of a cell and its neighbours; of equals the first.
  bool peaks(int map, int x, int y) const {
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        if (!covers(x + dx, y + dy)) continue;
        const float other = at(map, x + dx, y + dy), here = at(map, x, y);
        const bool before = dy < 0 || (dy == 0 && dx < 0);
        if (before ? other >= here : other > here) return false;
      }
    return true;
  }

  /// The middle of a peak between its cells.
  Eigen::Vector2f centre(int map, int x, int y) const {
    Eigen::Vector2f sum = Eigen::Vector2f::Zero();
    float total = 0;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        if (!covers(x + dx, y + dy)) continue;
        const float weight = 1 / (1 + std::exp(-at(map, x + dx, y + dy)));
        sum += weight * Eigen::Vector2f(dx, dy);
        total += weight;
      }
    return Eigen::Vector2f(x, y) + sum / std::max(total, 1e-6f);
  }

  /// The largest of a cell and its neighbours; `beyond` where the grid ends.
  float largest_about(int map, const Eigen::Vector2f& place, float beyond) const {
    const int x = static_cast<int>(std::lround(place.x())),
              y = static_cast<int>(std::lround(place.y()));
    if (!covers(x, y)) return beyond;
    float largest = beyond;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx)
        if (covers(x + dx, y + dy)) largest = std::max(largest, at(map, x + dx, y + dy));
    return largest;
  }

 private:
  std::span<const float> numbers_;
};

}  // namespace handyar
