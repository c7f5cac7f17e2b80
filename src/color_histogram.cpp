// SPDX-License-Identifier: MIT
#include "handyar/color_histogram.hpp"

#include <algorithm>
#include <bit>
#include <cstdlib>

#include "vectorised.hpp"

namespace handyar {
namespace {

constexpr std::uint32_t bit(int level) { return std::uint32_t{1} << level; }

constexpr std::uint32_t kFineRows = bit(kCoarseChroma) - bit(kFineChroma);

using Row = BinPlane::Row;

/// 1 2 1 along the fine levels of a row, the outermost mirrored.
[[gnu::always_inline]] inline void smooth_along(Row& row) {
  constexpr int kFirst = kFineChroma, kLast = kCoarseChroma - 1;
  const Row at = row;
  for (int k = kFirst; k <= kLast; ++k)
    row[k] = 0.25f * at[k - 1] + 0.5f * at[k] + 0.25f * at[k + 1];
  row[kFirst] = 0.75f * at[kFirst] + 0.25f * at[kFirst + 1];
  row[kLast] = 0.25f * at[kLast - 1] + 0.75f * at[kLast];
}

/// The same across the rows of fine chroma.
[[gnu::always_inline]] inline void smooth_across(BinPlane& plane) {
  const std::uint32_t held = plane.filled & kFineRows;
  const std::uint32_t reached = (held | held << 1 | held >> 1) & kFineRows;
  for_each_row(reached & ~held, [&](int row) { plane.rows[row] = {}; });
  plane.filled |= reached;
  Row before{};  // the row below, as it was
  int last = -1;
  for_each_row(reached, [&](int row) {
    const Row at = plane.rows[row];
    const Row& below = row == kFineChroma ? at : last == row - 1 ? before : BinPlane::kEmpty;
    const Row& above = row == kCoarseChroma - 1 ? at : plane.row(row + 1);
    for (int k = 0; k < kBinLevels; ++k)
      plane.rows[row][k] = 0.25f * below[k] + 0.5f * at[k] + 0.25f * above[k];
    before = at;
    last = row;
  });
}

/// Adds `weight` times the filled rows at `count` to the plane.
[[gnu::always_inline]] inline void add_rows(const float* count, std::uint32_t filled, float weight,
                                            BinPlane& plane) {
  for_each_row(filled, [&](int row) {
    const float* from = count + row * kBinLevels;
    Row& to = plane.rows[row];
    if ((plane.filled & bit(row)) == 0) to = {};
    for (int k = 0; k < kBinLevels; ++k) to[k] += weight * from[k];
  });
  plane.filled |= filled;
}

HANDYAR_VECTORISED void smooth_plane(const float* count, const ColorHistogram::Filled& filled,
                                     const BinSmoothing& smoothing, int luma, BinPlane& out) {
  out.filled = 0;
  const int times = smoothing.times;
  for (int apart = -times; apart <= times; ++apart) {
    const int to = luma + apart;
    const int from = to < 0 ? -1 - to : to >= kBinLevels ? 2 * kBinLevels - 1 - to : to;
    add_rows(count + from * kBinLevels * kBinLevels, filled[from],
             smoothing.weight[std::abs(apart)], out);
  }
  for (int time = 0; time < times; ++time) {
    for_each_row(out.filled, [&](int row) { smooth_along(out.rows[row]); });
    smooth_across(out);
  }
}

HANDYAR_VECTORISED void decay_rows(float* count, float keep, ColorHistogram::Filled& filled) {
  constexpr float kForgotten = 1e-4f;  // of a sample
  for (int luma = 0; luma < kBinLevels; ++luma, count += kBinLevels * kBinLevels)
    for_each_row(filled[luma], [&](int row) {
      float* const at = count + row * kBinLevels;
      std::uint32_t bits = 0;  // counts are never negative, and their bits are soon read
      for (int k = 0; k < kBinLevels; ++k) {
        at[k] = at[k] * keep < kForgotten ? 0.0f : at[k] * keep;
        bits |= std::bit_cast<std::uint32_t>(at[k]);
      }
      if (bits == 0) filled[luma] &= ~bit(row);
    });
}

}  // namespace

BinSmoothing::BinSmoothing(int wanted) noexcept : times(std::clamp(wanted, 0, kMost)) {
  weight[0] = 1;
  for (int time = 0; time < times; ++time) {
    float before = weight[1];
    for (int apart = 0; apart <= time + 1; ++apart) {
      const float at = weight[apart];
      weight[apart] = 0.25f * before + 0.5f * at + 0.25f * weight[apart + 1];
      before = at;
    }
  }
}

ColorHistogram& ColorHistogram::operator=(const ColorHistogram& other) noexcept {
  if (this == &other) return *this;
  clear();
  for (int luma = 0; luma < kBinLevels; ++luma)
    for_each_row(other.filled_[luma], [&](int row) {
      const int first = (luma * kBinLevels + row) * kBinLevels;
      std::copy_n(other.count_.begin() + first, kBinLevels, count_.begin() + first);
    });
  filled_ = other.filled_;
  total_ = other.total_;
  return *this;
}

void ColorHistogram::clear() noexcept {
  for (int luma = 0; luma < kBinLevels; ++luma)
    for_each_row(filled_[luma], [&](int row) {
      std::fill_n(count_.begin() + (luma * kBinLevels + row) * kBinLevels, kBinLevels, 0.0f);
    });
  filled_ = {};
  total_ = 0;
}

void ColorHistogram::add(std::span<const ColorBin> bins) noexcept {
  for (const ColorBin b : bins) {
    count_[b] += 1;
    filled_[b / (kBinLevels * kBinLevels)] |= bit(b / kBinLevels % kBinLevels);
  }
  total_ += static_cast<float>(bins.size());
}

void ColorHistogram::add(ColorBin bin, float weight) noexcept {
  count_[bin] += weight;
  filled_[bin / (kBinLevels * kBinLevels)] |= bit(bin / kBinLevels % kBinLevels);
  total_ += weight;
}

void ColorHistogram::decay(float keep) noexcept {
  decay_rows(count_.data(), keep, filled_);
  total_ *= keep;
}

void ColorHistogram::smooth(const BinSmoothing& smoothing, int luma, BinPlane& out) const noexcept {
  smooth_plane(count_.data(), filled_, smoothing, luma, out);
}

}  // namespace handyar
