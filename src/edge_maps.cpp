// SPDX-License-Identifier: MIT
#include "handyar/edge_maps.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "vectorised.hpp"

namespace handyar {
namespace {

constexpr int kBeyond = 6;         // what the margin holds: about what a picture holds
constexpr int kHalfStrength = 12;  // difference of two neighbours that counts for a half
constexpr int kTableReach = 63;    // of the table of edges; larger differences are halved

// Levels of luma, yellowness and redness side by side in a word, which has room for sums of 33.
constexpr int kFieldBits = 10;
constexpr float kMostScale = 32;
constexpr std::uint32_t kField = (1u << kFieldBits) - 1;

HANDYAR_VECTORISED void add_levels(const ColorBin* bins, int count,
                                   std::uint32_t* __restrict sums) {
  for (int k = 0; k < count; ++k) {
    const std::uint32_t b = bins[k];
    sums[k] +=
        (b & 31 << 10) << 2 * (kFieldBits - 5) | (b & 31 << 5) << (kFieldBits - 5) | (b & 31);
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
  highest_.resize(max_side + 4 * kMargin);
}

EdgeMaps::Edge EdgeMaps::edge(int gx, int gy) const noexcept {
  while (std::max(std::abs(gx), std::abs(gy)) > kTableReach) {
    gx /= 2;
    gy /= 2;
  }
  return edge_table_[(gy + kTableReach) * (2 * kTableReach + 1) + gx + kTableReach];
}

int EdgeMaps::nearest_direction(const Eigen::Vector2f& normal) const noexcept {
  const Eigen::Vector2f g = normal * (kTableReach / normal.cwiseAbs().maxCoeff());
  const Edge e = edge(static_cast<int>(g.x()), static_cast<int>(g.y()));
  return e.next_strength > e.strength ? (e.direction + 1) % kDirections : e.direction;
}

int EdgeMaps::edge_at(const Eigen::Vector2f& p, const Eigen::Vector2f& normal) const noexcept {
  const int x = static_cast<int>(p.x() + 0.5f), y = static_cast<int>(p.y() + 0.5f);
  if (x < 0 || y < 0 || x >= width_ || y >= height_) return kBeyond;
  return maps_[offset(nearest_direction(normal), x, y)];
}

/// Mean luma, yellowness and redness.
void EdgeMaps::read_colors(const BinView& image, int width, int height) noexcept {
  constexpr int kShift = 40;
  constexpr std::uint64_t kOne = std::uint64_t{1} << kShift;
  const int least = static_cast<int>(scale_);  // bins of a pixel across, or one or two more
  std::uint8_t* color = colors_.data();
  for (int v = 0; v < height; ++v) {
    const int y0 = static_cast<int>(static_cast<float>(v) * scale_);
    const int y1 = std::max(y0 + 1, static_cast<int>(static_cast<float>(v + 1) * scale_));
    // Divisions would take a third of the time. Rounded up, these give the same.
    std::array<std::uint64_t, 3> inverse;
    for (int more = 0; more < 3; ++more) inverse[more] = kOne / ((least + more) * (y1 - y0)) + 1;
    std::array<std::uint32_t, 1024> columns;  // sums over the bins of each, from `first` on
    int first = 0, last = 0, x1 = 0;
    for (int u = 0; u < width; ++u, color += 3) {
      const int x0 = x1;
      x1 = std::clamp(static_cast<int>(static_cast<float>(u + 1) * scale_), x0 + least,
                      x0 + least + 2);
      if (x1 > last) {
        first = x0;
        last = std::min(first + static_cast<int>(columns.size()), image.width);
        std::fill_n(columns.begin(), last - first, 0u);
        for (int y = y0; y < y1; ++y)
          add_levels(image.row(y) + first, last - first, columns.data());
      }
      std::uint64_t luma = 0, yellowness = 0, redness = 0;
      for (int k = x0 - first; k < x1 - first; ++k) {
        luma += columns[k] >> 2 * kFieldBits;
        yellowness += columns[k] >> kFieldBits & kField;
        redness += columns[k] & kField;
      }
      const std::uint64_t per_bin = inverse[x1 - x0 - least];
      color[0] = static_cast<std::uint8_t>(8 * luma * per_bin >> kShift);
      color[1] = static_cast<std::uint8_t>(2 * yellowness * per_bin >> kShift);
      color[2] = static_cast<std::uint8_t>(2 * redness * per_bin >> kShift);
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
  for (int v = 0; v < h; ++v) {
    const int row = (v + kMargin) * width_ + kMargin;
    for (int m = 0; m < kDirections; ++m) std::fill_n(edges + m * size + row, w, std::uint8_t{0});
    if (v == 0 || v + 1 == h) continue;
    const std::uint8_t* p = colors_.data() + 3 * v * w;
    for (int u = 1; u + 1 < w; ++u) {
      p += 3;
      int strongest = -1, gx = 0, gy = 0;
      for (int c = 0; c < 3; ++c) {
        const int dx = p[c + 3] - p[c - 3], dy = p[c + 3 * w] - p[c - 3 * w];
        if (dx * dx + dy * dy <= strongest) continue;
        strongest = dx * dx + dy * dy;
        gx = dx;
        gy = dy;
      }
      const Edge e = edge(gx, gy);
      std::uint8_t* to = edges + row + u;
      to[e.direction * size] = e.strength;
      to[(e.direction + 1) % kDirections * size] = e.next_strength;
      to[kCalm * size] = e.calm;
    }
  }
  for (int m = 0; m < kMaps; ++m) spread(m);
  return true;
}

/// Edges reach one pixel further on every side, for hands differ; columns are sorted.
void EdgeMaps::spread(int map) noexcept {
  const int w = width_;
  const std::uint8_t* from = maps_.data() + (map + 1) * w * height_;
  std::uint8_t* __restrict even = maps_.data() + offset(map, 0, 0);
  std::uint8_t* __restrict odd = maps_.data() + offset(map, 1, 0);
  std::uint8_t* __restrict high = highest_.data() + 1;
  for (int y = 0; y < height_; ++y, even += w / 2, odd += w / 2) {
    const std::uint8_t* at = from + y * w;
    if (map == kCalm) {
      for (int k = 0; k < w / 2; ++k) even[k] = at[2 * k];
      for (int k = 0; k < w / 2; ++k) odd[k] = at[2 * k + 1];
      continue;
    }
    const std::uint8_t *above = from + std::max(y - 1, 0) * w,
                       *below = from + std::min(y + 1, height_ - 1) * w;
    for (int x = 0; x < w; ++x) high[x] = std::max(at[x], std::max(above[x], below[x]));
    high[-1] = high[0];
    high[w] = high[w - 1];
    for (int k = 0; k < w / 2; ++k)
      even[k] = std::max(high[2 * k], std::max(high[2 * k - 1], high[2 * k + 1]));
    for (int k = 0; k < w / 2; ++k)
      odd[k] = std::max(high[2 * k + 1], std::max(high[2 * k], high[2 * k + 2]));
  }
}

}  // namespace handyar
