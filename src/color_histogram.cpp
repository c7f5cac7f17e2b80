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

/// A row, its fine levels smoothed.
[[gnu::always_inline]] inline void smooth_along(const BinSmoothing& s, int reach, const Row& from,
                                                Row& to) {
  constexpr int kLevels = kCoarseChroma - kFineChroma, kLast = kCoarseChroma - 1;
  to = from;
  if (reach == 1) {  // most often: needs no padding
    const float side = s.weight[1], middle = s.weight[0];
    for (int k = kFineChroma + 1; k < kLast; ++k)
      to[k] = side * from[k - 1] + middle * from[k] + side * from[k + 1];
    to[kFineChroma] =
        side * from[kFineChroma] + middle * from[kFineChroma] + side * from[kFineChroma + 1];
    to[kLast] = side * from[kLast - 1] + middle * from[kLast] + side * from[kLast];
    return;
  }
  std::array<float, 3 * kLevels> padded;  // from level kFineChroma - kLevels on
  for (int k = 0; k < kLevels; ++k) padded[kLevels + k] = from[kFineChroma + k];
  for (int k = 1; k <= reach; ++k) {
    padded[kLevels - k] = padded[kLevels + k - 1];
    padded[2 * kLevels - 1 + k] = padded[2 * kLevels - k];
  }
  std::array<float, kLevels> sum{};
  for (int apart = -reach; apart <= reach; ++apart) {
    const float weight = s.weight[std::abs(apart)];
    const float* at = padded.data() + kLevels + apart;
    for (int k = 0; k < kLevels; ++k) sum[k] += weight * at[k];
  }
  for (int k = 0; k < kLevels; ++k) to[kFineChroma + k] = sum[k];
}

/// The rows of fine chroma among those that are filled.
[[gnu::always_inline]] inline void smooth_across(const BinSmoothing& s, int reach,
                                                 const std::array<Row, kBinLevels>& from,
                                                 BinPlane& to) {
  const std::uint32_t fine = bit(kCoarseChroma) - bit(kFineChroma), held = to.filled & fine;
  for_each_row(to.filled & ~fine, [&](int row) { to.rows[row] = from[row]; });
  for (int row = kChroma.begin; held != 0 && row < kChroma.end; ++row) {
    const std::uint64_t reached = ((std::uint64_t{2} << 2 * reach) - 1) << row >> reach;
    if ((held & reached) == 0) continue;
    to.filled |= bit(row);
    const auto tap = [&](int apart) {
      const int at = kChroma.mirrored(row + apart);
      return (held & bit(at)) != 0 ? &from[at] : nullptr;
    };
    if (reach == 1) {
      const auto row_of = [](const Row* r) -> const Row& { return r ? *r : BinPlane::kEmpty; };
      const Row &before = row_of(tap(-1)), &here = row_of(tap(0)), &after = row_of(tap(1));
      const float side = s.weight[1], middle = s.weight[0];
      for (int k = 0; k < kBinLevels; ++k)
        to.rows[row][k] = side * before[k] + middle * here[k] + side * after[k];
      continue;
    }
    Row sum{};
    for (int apart = -reach; apart <= reach; ++apart) {
      const Row* const at = tap(apart);
      if (at == nullptr) continue;
      const float weight = s.weight[std::abs(apart)];
      for (int k = 0; k < kBinLevels; ++k) sum[k] += weight * (*at)[k];
    }
    to.rows[row] = sum;
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
  std::array<Row, kBinLevels> along;
  for_each_row(out.filled, [&](int row) { smooth_along(s, reach, out.rows[row], along[row]); });
  smooth_across(s, reach, along, out);
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
    if (count_[b] == 0) mark(b);
    count_[b] += 1;
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
