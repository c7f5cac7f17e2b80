// SPDX-License-Identifier: MIT
#include "handyar/edge_maps.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "vectorised.hpp"

namespace handyar {
namespace {

constexpr int kHalfStrength = 12;  // difference of two neighbours that counts for a half

// Levels of luma, yellowness and redness side by side in a word, which has room for sums of 33.
constexpr int kFieldBits = 10;
constexpr float kMostScale = 32;
constexpr std::uint32_t kField = (1u << kFieldBits) - 1;
// The same with room for sums of a pixel, and for their differences however large they are.
constexpr int kWideFieldBits = 21;
std::uint64_t widened(std::uint32_t levels) {
  const std::uint64_t luma = levels >> 2 * kFieldBits, yellowness = levels >> kFieldBits & kField;
  return luma << 2 * kWideFieldBits | yellowness << kWideFieldBits | (levels & kField);
}

HANDYAR_VECTORISED void add_levels(const ColorBin* bins, int count,
                                   std::uint32_t* __restrict sums) {
  for (int k = 0; k < count; ++k) {
    const std::uint32_t b = bins[k];
    sums[k] +=
        (b & 31 << 10) << 2 * (kFieldBits - 5) | (b & 31 << 5) << (kFieldBits - 5) | (b & 31);
  }
}

/// Means of sums, in units of 1/scale, rounded down: half a unit keeps whole numbers whole.
HANDYAR_VECTORISED void means(const std::uint16_t* sums, float scale, const float* per_column,
                              float per_row, int count, std::uint8_t* __restrict out) {
  for (int k = 0; k < count; ++k)
    out[k] = static_cast<std::uint8_t>((scale * sums[k] + 0.5f) * (per_column[k] * per_row));
}

/// The steps of colour across each pixel in the channel where they are largest; a row's channels
/// lie one after the other.
HANDYAR_VECTORISED void largest_steps(const std::uint8_t* above, const std::uint8_t* at,
                                      const std::uint8_t* below, int width,
                                      std::int16_t* __restrict gx, std::int16_t* __restrict gy) {
  for (int u = 1; u + 1 < width; ++u) {
    int x = 0, y = 0, most = -1;
    const auto consider = [&](int k) __attribute__((always_inline)) {
      const int dx = at[k + 1] - at[k - 1], dy = below[k] - above[k], size = dx * dx + dy * dy;
      x = size > most ? dx : x;
      y = size > most ? dy : y;
      most = std::max(most, size);
    };
    consider(u);
    consider(u + width);
    consider(u + 2 * width);
    gx[u] = static_cast<std::int16_t>(x);
    gy[u] = static_cast<std::int16_t>(y);
  }
}

/// The map of one direction: of each edge the share that it has of its own and of the next one.
HANDYAR_VECTORISED void draw_edges(const std::uint8_t* direction, int map,
                                   const std::uint8_t* strength, const std::uint8_t* next_strength,
                                   int width, std::uint8_t* __restrict to) {
  // In bytes and without branches, so that vectors are full.
  const auto own = static_cast<std::uint8_t>(map);
  const auto before =
      static_cast<std::uint8_t>((map + EdgeMaps::kDirections - 1) % EdgeMaps::kDirections);
  for (int u = 0; u < width; ++u) {
    const auto is_own = static_cast<std::uint8_t>(-(direction[u] == own));
    const auto is_before = static_cast<std::uint8_t>(-(direction[u] == before));
    to[u] = static_cast<std::uint8_t>((strength[u] & is_own) | (next_strength[u] & is_before));
  }
}

/// The largest of each pixel of a row and its eight neighbours. There is one before and one behind.
HANDYAR_VECTORISED void highest_around(const std::uint8_t* above, const std::uint8_t* at,
                                       const std::uint8_t* below, int width,
                                       std::uint8_t* __restrict column,
                                       std::uint8_t* __restrict out) {
  for (int x = 0; x < width; ++x) column[x] = std::max(at[x], std::max(above[x], below[x]));
  column[-1] = column[0];
  column[width] = column[width - 1];
  for (int x = 0; x < width; ++x)
    out[x] = std::max(column[x], std::max(column[x - 1], column[x + 1]));
}

/// Even and odd columns apart.
HANDYAR_VECTORISED void sort_columns(const std::uint8_t* row, int pairs,
                                     std::uint8_t* __restrict even, std::uint8_t* __restrict odd) {
  for (int k = 0; k < pairs; ++k) {
    even[k] = row[2 * k];
    odd[k] = row[2 * k + 1];
  }
}

}  // namespace

EdgeMaps::EdgeMaps() {
  edge_table_.resize((2 * kTableReach + 1) * (2 * kTableReach + 1));
  for (int gy = -kTableReach, k = 0; gy <= kTableReach; ++gy)
    for (int gx = -kTableReach; gx <= kTableReach; ++gx, ++k) {
      const float strength = std::hypot(static_cast<float>(gx), static_cast<float>(gy));
      const float share = std::min(1.0f, 1.2f * strength / (strength + kHalfStrength));
      float turns = std::atan2(static_cast<float>(gy), static_cast<float>(gx)) /
                    std::numbers::pi_v<float> * kDirections;
      if (turns < 0) turns += kDirections;
      const float rest = turns - std::floor(turns);
      edge_table_[k] = {static_cast<std::uint8_t>(static_cast<int>(turns) % kDirections),
                        static_cast<std::uint8_t>(kMost * share * (1 - rest)),
                        static_cast<std::uint8_t>(kMost * share * rest),
                        static_cast<std::uint8_t>(kMost * (1 - share))};
    }
}

void EdgeMaps::reserve(int max_pixels, int max_side, float least_scale) {
  room_ = static_cast<std::size_t>(static_cast<float>(max_pixels) / (least_scale * least_scale) +
                                   4 * (kMargin + 1) *
                                       (static_cast<float>(max_side) / least_scale + kMargin + 1));
  colors_.resize(3 * room_);
  maps_.resize((kMaps + 1) * room_ + 2 * kBlock);  // whole blocks are read
  for (auto* row : {&directions_, &strengths_, &next_strengths_, &columns_, &highest_})
    row->resize(max_side + 4 * kMargin);
  for (auto* row : {&steps_x_, &steps_y_}) row->resize(max_side + 4 * kMargin);
}

const EdgeMaps::Edge& EdgeMaps::edge(int gx, int gy) const noexcept {
  while (std::max(std::abs(gx), std::abs(gy)) > kTableReach) {
    gx /= 2;
    gy /= 2;
  }
  return edge_in_table(gx, gy);
}

/// Mean luma, yellowness and redness; a row's channels lie one after the other.
void EdgeMaps::read_colors(const BinView& image, int width, int height) noexcept {
  constexpr int kRoom = 1024;                  // columns of bins at a time
  const int least = static_cast<int>(scale_);  // bins of a pixel across, or one or two more
  std::array<std::uint16_t, kRoom + 1> begin;  // of each pixel's columns
  std::array<float, kRoom> per_column;
  std::array<std::uint32_t, kRoom> columns;     // sums of each
  std::array<std::uint64_t, kRoom + 1> before;  // and of all before it
  std::array<std::array<std::uint16_t, kRoom>, 3> sums;
  for (int u0 = 0, x0 = 0, count = 0; u0 < width; u0 += count, x0 += begin[count]) {
    begin[count = 0] = 0;
    for (; u0 + count < width; ++count) {
      const int x = x0 + begin[count];
      const int next = std::clamp(static_cast<int>(static_cast<float>(u0 + count + 1) * scale_),
                                  x + least, std::min(x + least + 2, image.width));
      if (next - x0 > kRoom) break;
      begin[count + 1] = static_cast<std::uint16_t>(next - x0);
      per_column[count] = 1 / static_cast<float>(next - x);
    }
    for (int v = 0; v < height; ++v) {
      const int y0 = static_cast<int>(static_cast<float>(v) * scale_);
      const int y1 = std::max(y0 + 1, static_cast<int>(static_cast<float>(v + 1) * scale_));
      std::fill_n(columns.begin(), begin[count], 0u);
      for (int y = y0; y < y1; ++y) add_levels(image.row(y) + x0, begin[count], columns.data());
      before[0] = 0;
      for (int k = 0; k < begin[count]; ++k) before[k + 1] = before[k] + widened(columns[k]);
      for (int k = 0; k < count; ++k) {
        const std::uint64_t sum = before[begin[k + 1]] - before[begin[k]];
        for (int c = 0; c < 3; ++c)
          sums[c][k] = static_cast<std::uint16_t>(sum >> (2 - c) * kWideFieldBits);
      }
      constexpr std::array<float, 3> kScales{8, 2, 2};
      for (int c = 0; c < 3; ++c)
        means(sums[c].data(), kScales[c], per_column.data(), 1 / static_cast<float>(y1 - y0), count,
              colors_.data() + (3 * v + c) * width + u0);
    }
  }
}

bool EdgeMaps::read(const BinView& image, float scale) noexcept {
  const int w = static_cast<int>(static_cast<float>(image.width) / scale);
  const int h = static_cast<int>(static_cast<float>(image.height) / scale);
  const int width = (w + 2 * kMargin + 1) & ~1, height = h + 2 * kMargin, size = width * height;
  if (!(scale >= 1 && scale <= kMostScale) || static_cast<std::size_t>(size) > room_ ||
      static_cast<std::size_t>(width + 2) > highest_.size())
    return false;
  scale_ = scale;
  width_ = width;
  height_ = height;
  read_colors(image, w, h);
  std::uint8_t* const edges = maps_.data() + size;  // of each map where the next will be
  std::fill_n(edges, kDirections * size, std::uint8_t{kBeyond});
  std::fill_n(edges + kCalm * size, size, std::uint8_t{kMost - kBeyond});
  for (int v = 0; v < h; ++v) find_edges(v, w, h, edges + (v + kMargin) * width_ + kMargin);
  for (int m = 0; m < kMaps; ++m) spread(m);
  return true;
}

/// Of a row of the reduced picture, into a row of each of the maps; none where a neighbour is
/// missing.
void EdgeMaps::find_edges(int v, int width, int height, std::uint8_t* to) noexcept {
  const int size = width_ * height_;
  for (auto* row : {&directions_, &strengths_, &next_strengths_})
    std::fill_n(row->begin(), width, 0);
  if (v > 0 && v + 1 < height) {
    const std::uint8_t* const at = colors_.data() + 3 * v * width;
    largest_steps(at - 3 * width, at, at + 3 * width, width, steps_x_.data(), steps_y_.data());
    for (int u = 1; u + 1 < width; ++u) {
      const Edge e = edge(steps_x_[u], steps_y_[u]);
      directions_[u] = e.direction;
      strengths_[u] = e.strength;
      next_strengths_[u] = e.next_strength;
      to[kCalm * size + u] = e.calm;
    }
  }
  for (int m = 0; m < kDirections; ++m)
    draw_edges(directions_.data(), m, strengths_.data(), next_strengths_.data(), width,
               to + m * size);
}

/// Edges reach one pixel further on every side, for hands differ; columns are sorted.
void EdgeMaps::spread(int map) noexcept {
  const int w = width_;
  const std::uint8_t* const from = maps_.data() + (map + 1) * w * height_;
  std::uint8_t *even = maps_.data() + offset(map, 0, 0), *odd = maps_.data() + offset(map, 1, 0);
  for (int y = 0; y < height_; ++y, even += w / 2, odd += w / 2) {
    const std::uint8_t* row = from + y * w;
    if (map != kCalm) {
      highest_around(from + std::max(y - 1, 0) * w, row, from + std::min(y + 1, height_ - 1) * w, w,
                     columns_.data() + 1, highest_.data());
      row = highest_.data();
    }
    sort_columns(row, w / 2, even, odd);
  }
}

}  // namespace handyar
