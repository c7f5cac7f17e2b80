// SPDX-License-Identifier: MIT
#include "handyar/color_histogram.hpp"

#include <algorithm>
#include <bit>
#include <cstdlib>

#include "vectorised.hpp"

namespace handyar {
namespace {

constexpr std::uint32_t bit(int level) { return std::uint32_t{1} << level; }

using Row = BinPlane::Row;

/// Levels of a channel that are smoothed among themselves: what would fall outside is mirrored.
struct Levels {
  int begin, end;

  [[gnu::always_inline]] int mirrored(int level) const {
    return level < begin ? 2 * begin - 1 - level : level >= end ? 2 * end - 1 - level : level;
  }
};
constexpr Levels kLuma{0, kBinLevels}, kChroma{kFineChroma, kCoarseChroma};

/// The fine levels of a row.
[[gnu::always_inline]] inline void smooth_along(const BinSmoothing& s, int reach, Row& row) {
  constexpr int kLevels = kCoarseChroma - kFineChroma;
  std::array<float, 3 * kLevels> padded;  // from level kFineChroma - kLevels on
  for (int k = 0; k < kLevels; ++k) padded[kLevels + k] = row[kFineChroma + k];
  for (int k = 1; k <= reach; ++k) {
    padded[kLevels - k] = padded[kLevels + k - 1];
    padded[2 * kLevels - 1 + k] = padded[2 * kLevels - k];
  }
  std::array<float, kLevels> sum{};
  for (int apart = -reach; apart <= reach; ++apart) {
    const float weight = s.weight[std::abs(apart)];
    const float* from = padded.data() + kLevels + apart;
    for (int k = 0; k < kLevels; ++k) sum[k] += weight * from[k];
  }
  for (int k = 0; k < kLevels; ++k) row[kFineChroma + k] = sum[k];
}

/// The rows of fine chroma.
[[gnu::always_inline]] inline void smooth_across(const BinSmoothing& s, int reach,
                                                 BinPlane& plane) {
  const std::uint32_t held = plane.filled & (bit(kCoarseChroma) - bit(kFineChroma));
  std::array<Row, kBinLevels> before;
  for_each_row(held, [&](int row) { before[row] = plane.rows[row]; });
  for (int row = kChroma.begin; held != 0 && row < kChroma.end; ++row) {
    const std::uint64_t reached = ((std::uint64_t{2} << 2 * reach) - 1) << row >> reach;
    if ((held & reached) == 0) continue;
    Row sum{};
    for (int apart = -reach; apart <= reach; ++apart) {
      const int from = kChroma.mirrored(row + apart);
      if ((held & bit(from)) == 0) continue;
      const float weight = s.weight[std::abs(apart)];
      for (int k = 0; k < kBinLevels; ++k) sum[k] += weight * before[from][k];
    }
    plane.rows[row] = sum;
    plane.filled |= bit(row);
  }
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

[[gnu::always_inline]] inline void smooth_plane(const float* count,
                                                const ColorHistogram::Filled& filled,
                                                const BinSmoothing& s, int reach, int luma,
                                                BinPlane& out) {
  out.filled = 0;
  for (int apart = -reach; apart <= reach; ++apart) {
    const int from = kLuma.mirrored(luma + apart);
    add_rows(count + first_bin(from, 0), filled[from], s.weight[std::abs(apart)], out);
  }
  for_each_row(out.filled, [&](int row) { smooth_along(s, reach, out.rows[row]); });
  smooth_across(s, reach, out);
}

HANDYAR_VECTORISED void smooth_plane(const float* count, const ColorHistogram::Filled& filled,
                                     const BinSmoothing& s, int luma, BinPlane& out) {
  if (s.reach == 1)  // most often: loops of known length
    smooth_plane(count, filled, s, 1, luma, out);
  else
    smooth_plane(count, filled, s, s.reach, luma, out);
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

BinSmoothing::BinSmoothing(int times) noexcept : reach(std::clamp(times, 0, kMostReach)) {
  weight[0] = 1;
  for (int time = 0; time < reach; ++time) {
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
      const int first = first_bin(luma, row);
      std::copy_n(other.count_.begin() + first, kBinLevels, count_.begin() + first);
    });
  filled_ = other.filled_;
  total_ = other.total_;
  return *this;
}

void ColorHistogram::clear() noexcept {
  for (int luma = 0; luma < kBinLevels; ++luma)
    for_each_row(filled_[luma], [&](int row) {
      std::fill_n(count_.begin() + first_bin(luma, row), kBinLevels, 0.0f);
    });
  filled_ = {};
  total_ = 0;
}

void ColorHistogram::add(std::span<const ColorBin> bins) noexcept {
  for (const ColorBin b : bins) {
    count_[b] += 1;
    mark(b);
  }
  total_ += static_cast<float>(bins.size());
}

void ColorHistogram::add(ColorBin bin, float weight) noexcept {
  count_[bin] += weight;
  mark(bin);
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
