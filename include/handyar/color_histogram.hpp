// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "handyar/color_bins.hpp"

namespace handyar {

/// `times` passes of smoothing by 1 2 1: weight[d] is that of a level d away, up to `reach`.
struct BinSmoothing {
  static constexpr int kMostReach = 15;  // less than a channel's levels
  int reach;
  std::array<float, kMostReach + 3> weight{};

  explicit BinSmoothing(int times = 1) noexcept;
};

/// The first bin of a row: of one luma and yellowness, all rednesses.
constexpr int first_bin(int luma, int row) noexcept {
  return (luma * kBinLevels + row) * kBinLevels;
}

/// The bins of one luma. A row of them has one yellowness and all rednesses.
struct BinPlane {
  using Row = std::array<float, kBinLevels>;
  static constexpr Row kEmpty{};

  std::uint32_t filled = 0;  ///< bit r: row r holds something; other rows hold what they may
  std::array<Row, kBinLevels> rows;

  const Row& row(int r) const noexcept { return filled >> r & 1 ? rows[r] : kEmpty; }
};

/// How often each colour bin was seen. A picture has few colours: most rows of bins are empty, and
/// only the others are touched.
class ColorHistogram {
 public:
  using Filled = std::array<std::uint32_t, kBinLevels>;

  ColorHistogram() : count_(kBinCount) {}
  ColorHistogram(const ColorHistogram&) = default;
  ColorHistogram& operator=(const ColorHistogram& other) noexcept;

  void clear() noexcept;
  void add(std::span<const ColorBin> bins) noexcept;
  void add(ColorBin bin, float weight) noexcept;
  /// Takes each count times `keep`; what is left of a sample's traces is forgotten.
  void decay(float keep) noexcept;

  float operator[](ColorBin bin) const noexcept { return count_[bin]; }
  float total() const noexcept { return total_; }  ///< of all bins
  /// Rows that hold something: bit r of word l is row r of luma l.
  const Filled& filled() const noexcept { return filled_; }

  /// Bins of one luma, each count spread over its neighbours along each channel, so that few
  /// samples stand for the colours around them.
  void smooth(const BinSmoothing& smoothing, int luma, BinPlane& out) const noexcept;

 private:
  void mark(ColorBin bin) noexcept {
    filled_[bin / (kBinLevels * kBinLevels)] |= std::uint32_t{1} << bin / kBinLevels % kBinLevels;
  }

  std::vector<float> count_;
  Filled filled_{};
  float total_ = 0;
};

/// Calls `visit(row)` for each bit of `filled`, a plane's or a histogram's of one luma.
template <class Visit>
[[gnu::always_inline]] inline void for_each_row(std::uint32_t filled, const Visit& visit) {
  for (; filled != 0; filled &= filled - 1) visit(std::countr_zero(filled));
}

}  // namespace handyar
