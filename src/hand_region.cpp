// SPDX-License-Identifier: MIT
#include "handyar/hand_region.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <limits>

namespace handyar {
namespace {

constexpr int kMaxRuns = 1 << 15;  // a region of noise has more; it is no hand
constexpr int kMaxRadius = 8;
constexpr int kEdgeRatio = 16;  // what a step of one level beyond the first counts against a hand

/// Largest difference of a channel, in levels.
int color_step(ColorBin p, ColorBin q) {
  return std::max({std::abs((p >> 10) - (q >> 10)), std::abs((p >> 5 & 31) - (q >> 5 & 31)),
                   std::abs((p & 31) - (q & 31))});
}

/// Each of `count` values becomes the combination of `window` values, `step` apart, from itself on.
/// A mask with its border of zeros is one long row: a shift by one pixel or by one row is a shift
/// of the whole, and windows grow by doubling.
template <class Combine>
void combine_window(std::uint8_t* p, std::ptrdiff_t count, std::ptrdiff_t step, int window,
                    Combine combine) {
  for (int covered = 1; covered < window;) {
    const int by = std::min(covered, window - covered);
    const std::uint8_t* ahead = p + by * step;
    for (std::ptrdiff_t i = 0; i < count; ++i) p[i] = combine(p[i], ahead[i]);
    covered += by;
  }
}

}  // namespace

void RegionFinder::reserve(int max_pixels) {
  // The border of the longest thin mask costs at most as much again as its pixels.
  mask_.pixels.resize(static_cast<std::size_t>(max_pixels) + 4 * 4098 + 4);
  colored_.resize(mask_.pixels.size());
  opened_.resize(mask_.pixels.size() + 4 * (kMaxRadius + 1) * 4100);
  runs_.resize(kMaxRuns);
  totals_.resize(kMaxRuns);
  for (auto& row : rows_) row.resize(4098);
  distance_.resize(130 * 130);  // deepest() reduces to at most 128 x 128
}

void RegionFinder::resize_mask(int width, int height) noexcept {
  mask_.width = width;
  mask_.height = height;
  const int stride = mask_.stride();
  std::memset(mask_.pixels.data(), 0, stride);
  std::memset(mask_.pixels.data() + static_cast<std::ptrdiff_t>(height + 1) * stride, 0, stride);
  for (int v = 0; v < height; ++v) mask_.row(v)[-1] = mask_.row(v)[width] = 0;
}

void RegionFinder::classify(const BinImage& image, std::span<const std::int8_t> ratios,
                            int threshold) noexcept {
  resize_mask(image.width, image.height);
  const ColorBin* bin = image.bins.data();
  for (int v = 0; v < image.height; ++v) {
    std::uint8_t* to = mask_.row(v);
    for (int u = 0; u < image.width; ++u) to[u] = ratios[*bin++] > threshold ? 255 : 0;
  }
}

void RegionFinder::classify(const BinImage& image, std::span<const std::int8_t> ratios,
                            const ExpectedRegion& expected) noexcept {
  resize_mask(image.width, image.height);
  const int w = image.width, h = image.height;
  const std::int8_t* table = ratios.data();
  // Sliding 3x3 sum: rows_[v % 3] holds row v summed over three columns, edges repeated.
  const auto sum_row = [&](int v) {
    std::int16_t* to = rows_[v % 3].data();
    const ColorBin* bin = image.bins.data() + static_cast<std::ptrdiff_t>(v) * w;
    int left = table[bin[0]], middle = left;
    for (int u = 0; u < w; ++u) {
      const int right = u + 1 < w ? table[bin[u + 1]] : middle;
      to[u] = static_cast<std::int16_t>(left + middle + right);
      left = middle;
      middle = right;
    }
  };
  if (h > 0) sum_row(0);
  for (int v = 0; v < h; ++v) {
    if (v + 1 < h) sum_row(v + 1);
    const int up = std::max(v - 1, 0), down = std::min(v + 1, h - 1);
    const std::int16_t *above = rows_[up % 3].data(), *at = rows_[v % 3].data(),
                       *below = rows_[down % 3].data();
    const ColorBin* bins = image.bins.data() + static_cast<std::ptrdiff_t>(v) * w;
    std::uint8_t *to = mask_.row(v), *colored = colored_.data() + (to - mask_.pixels.data());
    const std::int8_t* place = expected.row(v);
    for (int u = 0; u < w; ++place) {
      const int end = std::min(u + expected.cell, w), limit = -9 * *place;
      if (*place == ExpectedRegion::kInside) {
        for (; u < end; ++u) to[u] = colored[u] = above[u] + at[u] + below[u] > 0 ? 255 : 0;
      } else if (*place == ExpectedRegion::kOutside) {
        for (; u < end; ++u) to[u] = colored[u] = 0;
      } else {
        for (; u < end; ++u) {
          const int sum = above[u] + at[u] + below[u];
          colored[u] = sum > limit ? 255 : 0;
          to[u] = 0;
          if (sum <= limit) continue;
          const int edge =
              std::max(color_step(bins[std::max(u - 1, 0)], bins[std::min(u + 1, w - 1)]),
                       color_step(bins[u + (up - v) * w], bins[u + (down - v) * w]));
          to[u] = sum > limit + 9 * kEdgeRatio * (edge - 1) ? 255 : 0;
        }
      }
    }
  }
}

std::uint8_t* RegionFinder::copy_with_room(int radius) noexcept {
  const std::ptrdiff_t stride = mask_.stride(), count = stride * (mask_.height + 2);
  const std::ptrdiff_t reach = (2 * radius + 3) * (stride + 1);
  std::uint8_t* const at = opened_.data() + reach;
  std::fill_n(opened_.data(), reach, 0);
  std::copy_n(mask_.pixels.data(), count, at);
  std::fill_n(at + count, reach, 0);
  return at;
}

void RegionFinder::remove_thin(int radius) noexcept {
  radius = std::min(radius, kMaxRadius);
  if (radius < 1 || mask_.height == 0) return;
  const std::ptrdiff_t stride = mask_.stride(), count = stride * (mask_.height + 2);
  std::uint8_t* const at = copy_with_room(radius);
  const int eroded = 2 * radius + 1, grown = eroded + 2;
  combine_window(at, count, 1, eroded, std::bit_and<std::uint8_t>());
  combine_window(at, count, stride, eroded, std::bit_and<std::uint8_t>());
  // Windows begin before the first pixel.
  const std::ptrdiff_t before = (2 * radius + 2) * (stride + 1);
  combine_window(at - before, count + before, 1, grown, std::bit_or<std::uint8_t>());
  combine_window(at - before, count + before, stride, grown, std::bit_or<std::uint8_t>());
  const std::uint8_t* opened = at - (2 * radius + 1) * (stride + 1);
  for (std::ptrdiff_t i = 0; i < count; ++i) mask_.pixels[i] &= opened[i];
}

void RegionFinder::grow_back(int radius) noexcept {
  radius = std::min(radius, kMaxRadius);
  if (mask_.height == 0) return;
  const std::ptrdiff_t stride = mask_.stride(), count = stride * (mask_.height + 2);
  const std::ptrdiff_t before = radius * (stride + 1);
  std::uint8_t* const from = copy_with_room(radius) - before;
  combine_window(from, count + before, 1, 2 * radius + 1, std::bit_or<std::uint8_t>());
  combine_window(from, count + before, stride, 2 * radius + 1, std::bit_or<std::uint8_t>());
  for (std::ptrdiff_t i = stride; i < count - stride; ++i) mask_.pixels[i] = from[i] & colored_[i];
  for (int v = 0; v < mask_.height; ++v) mask_.row(v)[-1] = mask_.row(v)[mask_.width] = 0;
}

std::int32_t RegionFinder::root(std::int32_t run) noexcept {
  while (runs_[run].label != run) run = runs_[run].label = runs_[runs_[run].label].label;
  return run;
}

std::span<const Component> RegionFinder::components(int min_area) noexcept {
  run_count_ = 0;
  component_count_ = 0;
  int above_begin = 0, above_end = 0;
  for (int v = 0; v < mask_.height; ++v) {
    const std::uint8_t* row = mask_.row(v);
    const int begin = run_count_;
    int above = above_begin;
    for (int u = 0; u < mask_.width;) {
      // Zeros come in long stretches: skip them with the library's word-wise search.
      const void* found = std::memchr(row + u, 255, mask_.width - u);
      if (found == nullptr) break;
      const int u0 = static_cast<int>(static_cast<const std::uint8_t*>(found) - row);
      const int u1 = static_cast<int>(
          static_cast<const std::uint8_t*>(std::memchr(row + u0, 0, mask_.width + 1 - u0)) - row);
      u = u1 + 1;
      if (run_count_ == kMaxRuns) return {};
      const std::int32_t id = run_count_++;
      runs_[id] = {static_cast<std::int16_t>(v), static_cast<std::int16_t>(u0),
                   static_cast<std::int16_t>(u1), id};
      while (above < above_end && runs_[above].u1 < u0) ++above;  // touching corners count
      for (int k = above; k < above_end && runs_[k].u0 <= u1; ++k) {
        const std::int32_t a = root(id), b = root(k);
        if (a != b) runs_[std::max(a, b)].label = std::min(a, b);
      }
    }
    above_begin = begin;
    above_end = run_count_;
  }
  // The root of a component is its first run: top row, leftmost.
  for (int i = 0; i < run_count_; ++i) {
    const Run& r = runs_[i];
    const std::int32_t label = root(i);
    const int length = r.u1 - r.u0;
    Component& c = totals_[label];
    if (label == i) {
      c = {label, 0, Eigen::Vector2f::Zero(), r.u0, r.v, r.u1 - 1, r.v, r.u0};
    }
    c.area += length;
    c.centroid += Eigen::Vector2f(0.5f * (r.u0 + r.u1 - 1) * length, float(r.v) * length);
    c.u0 = std::min<int>(c.u0, r.u0);
    c.u1 = std::max<int>(c.u1, r.u1 - 1);
    c.v1 = r.v;
  }
  const auto larger = [](const Component& a, const Component& b) {
    return a.area != b.area ? a.area > b.area : a.label < b.label;
  };
  for (int i = 0; i < run_count_; ++i) {
    if (root(i) != i || totals_[i].area < min_area) continue;
    Component c = totals_[i];
    c.centroid /= static_cast<float>(c.area);
    if (component_count_ < kMaxComponents) {
      components_[component_count_++] = c;
    } else {
      auto smallest = std::max_element(components_, components_ + kMaxComponents, larger);
      if (larger(c, *smallest)) *smallest = c;
    }
  }
  std::sort(components_, components_ + component_count_, larger);
  return {components_, static_cast<std::size_t>(component_count_)};
}

const Component* RegionFinder::component_at(int u, int v) const noexcept {
  std::int32_t best = -1;
  int best_distance = std::numeric_limits<int>::max();
  for (int i = 0; i < run_count_; ++i) {
    const Run& r = runs_[i];
    const std::int32_t label = const_cast<RegionFinder*>(this)->root(i);
    const bool listed = std::any_of(components_, components_ + component_count_,
                                    [&](const Component& c) { return c.label == label; });
    if (!listed) continue;
    const int du = u < r.u0 ? r.u0 - u : std::max(u - (r.u1 - 1), 0), dv = v - r.v;
    if (du * du + dv * dv < best_distance) {
      best_distance = du * du + dv * dv;
      best = label;
    }
  }
  for (int i = 0; i < component_count_; ++i)
    if (components_[i].label == best) return &components_[i];
  return nullptr;
}

void RegionFinder::keep_only(const Component& component) noexcept {
  for (int i = 0; i < run_count_; ++i) {
    const Run& r = runs_[i];
    if (root(i) != component.label) std::memset(mask_.row(r.v) + r.u0, 0, r.u1 - r.u0);
  }
}

Disc RegionFinder::deepest(const Component& c) noexcept {
  // Chamfer 3-4 distance at a resolution at which the box is about 64 pixels across.
  const int box = std::max(c.u1 - c.u0, c.v1 - c.v0) + 1;
  const int step = std::max(1, box / 64);
  const int w = (c.u1 - c.u0) / step + 1, h = (c.v1 - c.v0) / step + 1, stride = w + 2;
  std::uint16_t* d = distance_.data();
  std::fill(d, d + static_cast<std::ptrdiff_t>(stride) * (h + 2), 0);
  // Other components may reach into the box: only this one's runs count. Its label is its first.
  for (int i = c.label; i < run_count_ && runs_[i].v <= c.v1; ++i) {
    const Run& r = runs_[i];
    if ((r.v - c.v0) % step != 0 || root(i) != c.label) continue;
    const int first = (r.u0 - c.u0 + step - 1) / step, last = (r.u1 - 1 - c.u0) / step;
    std::uint16_t* row = d + ((r.v - c.v0) / step + 1) * stride + 1;
    for (int u = first; u <= last; ++u) row[u] = 1;
  }
  for (int v = 0; v < h; ++v) {
    std::uint16_t* at = d + (v + 1) * stride + 1;
    for (int u = 0; u < w; ++u, ++at) {
      if (*at == 0) continue;
      const int nearest =
          std::min({at[-1] + 3, at[-stride] + 3, at[-stride - 1] + 4, at[-stride + 1] + 4});
      *at = static_cast<std::uint16_t>(nearest);
    }
  }
  Disc best;
  int deepest = 0;
  for (int v = h - 1; v >= 0; --v) {
    std::uint16_t* at = d + (v + 1) * stride + w;
    for (int u = w - 1; u >= 0; --u, --at) {
      if (*at == 0) continue;
      const int nearest =
          std::min({at[1] + 3, at[stride] + 3, at[stride + 1] + 4, at[stride - 1] + 4});
      *at = static_cast<std::uint16_t>(std::min<int>(*at, nearest));
      if (*at > deepest) {
        deepest = *at;
        best.center = Eigen::Vector2f(c.u0 + u * step, c.v0 + v * step);
      }
    }
  }
  best.radius = deepest / 3.0f * step;
  return best;
}

}  // namespace handyar
