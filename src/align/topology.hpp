// SPDX-License-Identifier: MIT
// Which discs of a figure's silhouette belong together.
#pragma once

#include <array>
#include <cstdint>
#include <utility>

#include "handyar/stages/hand_figure.hpp"

namespace handyar {

/// Of the two discs at the forearm's far end, the first; they come after the spheres.
inline constexpr int kForearm = kSphereCount;

/// Pairs of spheres that span a capsule, each once, and the sheets' triples; the forearm's behind.
struct Topology {
  struct Pair {
    std::uint8_t a, b;
  };
  std::array<Pair, 64> pairs{};
  int pair_count = 0, own_pairs = 0;
  std::array<std::array<std::uint8_t, 3>, 32> sheets{};
  int sheet_count = 0, own_sheets = 0;

  void add(int a, int b) {
    if (a > b) std::swap(a, b);
    for (int i = 0; i < pair_count; ++i)
      if (pairs[i].a == a && pairs[i].b == b) return;
    pairs[pair_count++] = {static_cast<std::uint8_t>(a), static_cast<std::uint8_t>(b)};
  }
  void add_sheet(int a, int b, int c) {
    sheets[sheet_count++] = {static_cast<std::uint8_t>(a), static_cast<std::uint8_t>(b),
                             static_cast<std::uint8_t>(c)};
  }

  Topology() {
    for (const auto& [a, b, c] : figure_hulls()) {
      add(a, b);
      if (c < 0) continue;
      add(b, c);
      add(a, c);
      add_sheet(a, b, c);
    }
    own_pairs = pair_count;
    own_sheets = sheet_count;
    add(kWristThumb, kForearm);
    add(kWristLittle, kForearm + 1);
    add_sheet(kWristThumb, kWristLittle, kForearm);
    add_sheet(kWristLittle, kForearm, kForearm + 1);
  }
};

inline const Topology& topology() {
  static const Topology t;
  return t;
}

}  // namespace handyar
