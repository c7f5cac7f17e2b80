// SPDX-License-Identifier: MIT
#include "handyar/hand_region.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "vectorised.hpp"

namespace handyar {
namespace {

constexpr int kMaxRuns = 3 << 12;  // a region of noise has more; it is no hand
constexpr int kMaxRadius = 8;
constexpr int kDeepestAcross = 64;  // resolution of deepest(): at least this, less than twice this
constexpr int kEdgeRatio = 16;  // what a step of one level beyond the first counts against a hand

/// Difference of two colours in levels of luma; two of chroma count as one.
[[gnu::always_inline]] inline int color_step(ColorBin p, ColorBin q) {
  const int chroma =
      std::max(std::abs((p >> 5 & 31) - (q >> 5 & 31)), std::abs((p & 31) - (q & 31)));
  return std::max(std::abs((p >> 10) - (q >> 10)), chroma / 2);
}

/// A row that is classified and its neighbours: sums of ratios over three columns, and bins.
struct Rows {
  const std::int16_t *above, *at, *below;
  const ColorBin *bins_above, *bins, *bins_below;
};
/// What the places of a row ask for: a sum of more than the limit, and by so much more for each
/// level of a step in colour beyond the first.
struct Demands {
  const std::int16_t *limit, *per_level;
};

HANDYAR_VECTORISED void classify_row(const Rows& rows, const Demands& demands, int width,
                                     std::uint8_t* __restrict hand,
                                     std::uint8_t* __restrict colored) {
  const auto classify = [&](int u, int left, int right) __attribute__((always_inline)) {
    const int sum = rows.above[u] + rows.at[u] + rows.below[u], limit = demands.limit[u];
    const int step = std::max(color_step(rows.bins[left], rows.bins[right]),
                              color_step(rows.bins_above[u], rows.bins_below[u]));
    colored[u] = sum > limit;
    hand[u] = (sum > limit) & (sum > limit + demands.per_level[u] * (step - 1));
  };
  if (width == 0) return;
  classify(0, 0, std::min(1, width - 1));
  for (int u = 1; u < width - 1; ++u) classify(u, u - 1, u + 1);
  classify(width - 1, std::max(width - 2, 0), width - 1);
}

/// Distances in a row of pixels, as far as they are those of a neighbouring row and a step.
HANDYAR_VECTORISED void distances_from(const std::int16_t* __restrict row, int width,
                                       std::int16_t* __restrict to) {
  for (int u = 0; u < width; ++u) {
    const auto straight = static_cast<std::int16_t>(row[u] + 3);
    const auto aslant = static_cast<std::int16_t>(std::min(row[u - 1], row[u + 1]) + 4);
    to[u] = std::min(to[u], std::min(straight, aslant));
  }
}

}  // namespace

void RegionFinder::reserve(int max_pixels, int max_side) {
  for (Mask* m : {&mask_, &colored_, &opened_, &scratch_}) m->reserve(max_pixels, max_side);
  runs_.resize(std::min(kMaxRuns, max_pixels / 2 + max_side));
  for (auto& row : rows_) row.resize(max_side);
  looked_up_.resize(max_side + 2);
  for (auto* row : {&limits_, &per_level_}) row->resize(max_side);
  for (auto* flags : {&flags_, &colored_flags_}) flags->resize(max_side + 64);
  distance_.resize((2 * kDeepestAcross + 2) * (2 * kDeepestAcross + 2));
}

void RegionFinder::expect_row(const ExpectedRegion& expected, int v) noexcept {
  const std::int8_t* place = expected.row(v);
  for (int u = 0; u < mask_.width; ++place) {
    const bool inside = *place == ExpectedRegion::kInside;
    const bool outside = *place == ExpectedRegion::kOutside;
    const int limit = inside ? 0 : outside ? std::numeric_limits<std::int16_t>::max() : -9 * *place;
    const int per_level = inside || outside ? 0 : 9 * kEdgeRatio;
    for (const int end = std::min(u + expected.cell, mask_.width); u < end; ++u) {
      limits_[u] = static_cast<std::int16_t>(limit);
      per_level_[u] = static_cast<std::int16_t>(per_level);
    }
  }
}

HANDYAR_VECTORISED void RegionFinder::classify(const BinView& image,
                                               std::span<const std::int8_t> ratios,
                                               const ExpectedRegion& expected) noexcept {
  const int w = image.width, h = image.height;
  const bool all_inside = expected.one_for_all() && *expected.row(0) == ExpectedRegion::kInside;
  mask_.resize(w, h);
  if (!all_inside) colored_.resize(w, h);
  const std::int8_t* table = ratios.data();
  // Sliding 3x3 sum: rows_[v % 3] holds row v summed over three columns, edges repeated.
  const auto sum_row = [&](int v) __attribute__((always_inline)) {
    // Looked up one by one, summed in vectors.
    std::int16_t* __restrict to = rows_[v % 3].data(), * __restrict ratio = looked_up_.data() + 1;
    const ColorBin* bin = image.row(v);
    for (int u = 0; u < w; ++u) ratio[u] = table[bin[u]];
    ratio[-1] = ratio[0];
    ratio[w] = ratio[w - 1];
    for (int u = 0; u < w; ++u)
      to[u] = static_cast<std::int16_t>(ratio[u - 1] + ratio[u] + ratio[u + 1]);
  };
  if (h > 0) sum_row(0);
  for (int v = 0; v < h; ++v) {
    if (v + 1 < h) sum_row(v + 1);
    const int up = std::max(v - 1, 0), down = std::min(v + 1, h - 1);
    const std::int16_t *above = rows_[up % 3].data(), *at = rows_[v % 3].data(),
                       *below = rows_[down % 3].data();
    std::uint8_t *to = flags_.data(), *colored = colored_flags_.data();
    if (all_inside) {
      for (int u = 0; u < w; ++u) to[u] = above[u] + at[u] + below[u] > 0;
    } else {
      if (v % expected.cell == 0) expect_row(expected, v);
      classify_row({above, at, below, image.row(up), image.row(v), image.row(down)},
                   {limits_.data(), per_level_.data()}, w, to, colored);
      colored_.set_row(v, colored);
    }
    mask_.set_row(v, to);
  }
  if (all_inside) colored_.copy(mask_);
}

void RegionFinder::remove_thin(int radius) noexcept {
  radius = std::min(radius, kMaxRadius);
  if (radius < 1 || mask_.height == 0) return;
  opened_.copy(mask_);
  erode(opened_, radius, scratch_);
  dilate(opened_, radius + 1, scratch_);
  intersect(mask_, opened_);
}

void RegionFinder::grow_back(int radius) noexcept {
  dilate(mask_, std::min(radius, kMaxRadius), scratch_);
  intersect(mask_, colored_);
}

const Component* RegionFinder::segment(const BinView& image, std::span<const std::int8_t> ratios,
                                       const ExpectedRegion& expected, const ExpectedHand& hand,
                                       int min_area) noexcept {
  classify(image, ratios, expected);
  remove_thin(std::max(1, static_cast<int>(0.14f * hand.finger_width + 0.5f)));
  const Component* region = component_of(hand, min_area);
  if (region == nullptr || expected.one_for_all()) return region;
  // Edges have cut the region: its border comes back, what hung on by a thread does not.
  grow_back(static_cast<int>(0.18f * hand.finger_width + 0.5f));
  return component_of(hand, min_area);
}

const Component* RegionFinder::component_of(const ExpectedHand& hand, int min_area) noexcept {
  const int u = static_cast<int>(hand.palm.x()), v = static_cast<int>(hand.palm.y());
  components(min_area);
  const Component* component = component_at(u, v);
  if (component == nullptr) return nullptr;
  bool joined = false;
  for (const ExpectedHand::Finger& finger : hand.fingers)
    joined |= join(finger, hand.finger_width, component->label);
  if (joined) {
    components(min_area);
    component = component_at(u, v);
    if (component == nullptr) return nullptr;
  }
  keep_only(*component);
  return component;
}

bool RegionFinder::join(const ExpectedHand::Finger& finger, float finger_width,
                        int label) noexcept {
  const float longest = 0.8f * finger_width, enough = 0.4f * finger_width;  // of gap and finger
  const float length = (finger.tip - finger.base).norm();
  if (!(length > finger_width)) return false;
  const Eigen::Vector2f along = (finger.tip - finger.base) / length;
  const Eigen::Vector2f across = finger_width * Eigen::Vector2f(-along.y(), along.x());
  // What is set at a station along the finger; a finger is seldom just where it is expected.
  float shift = 0;
  const auto label_along = [&](float s) {
    for (const float t : {0.0f, 0.25f, -0.25f}) {
      const int found = label_at(finger.base + s * along + t * across);
      if (found < 0) continue;
      shift = t;
      return found;
    }
    return -1;
  };
  const auto width_at = [&](float s, int of) {  // in finger widths, as far as it matters
    float width = 0;
    for (float t = -1; t <= 1; t += 0.1f)
      width += label_at(finger.base + s * along + (shift + t) * across) == of ? 0.1f : 0.0f;
    return width;
  };
  if (label_along(length - enough) == label) return false;
  float end = -std::numeric_limits<float>::max();  // of the hand
  for (float s = -finger_width; s < length; ++s) {
    const int here = label_along(s);
    if (here == label) end = s;
    if (here == label || here < 0 || s - end > longest) continue;
    const float before = width_at(end - 1, label), beyond = width_at(s + enough, here);
    if (before < 0.6f || beyond < 0.6f || beyond > 1.5f) return false;
    for (float at = end; at <= s; at += 0.5f)
      for (float t = -0.35f; t <= 0.35f; t += 0.5f / finger_width) {
        const Eigen::Vector2f p = finger.base + at * along + (shift + t) * across;
        mask_.set(p);
        colored_.set(p);
      }
    return true;
  }
  return false;
}

int RegionFinder::label_at(const Eigen::Vector2f& p) const noexcept {
  if (!mask_.holds(p)) return -1;
  const auto before = [](const Run& r, const Mask::Pixel& at) {
    return r.v < at.v || (r.v == at.v && r.u1 <= at.u);
  };
  const auto runs = runs_.begin();
  return std::lower_bound(runs, runs + run_count_, Mask::Pixel(p), before)->label;
}

int RegionFinder::root(int run) noexcept {
  while (runs_[run].label != run) run = runs_[run].label = runs_[runs_[run].label].label;
  return run;
}

std::span<const Component> RegionFinder::components(int min_area) noexcept {
  run_count_ = 0;
  component_count_ = 0;
  int above_begin = 0, above_end = 0;
  for (int v = 0; v < mask_.height; ++v) {
    const int begin = run_count_;
    int above = above_begin;
    for (int u0 = mask_.next_set(v, 0), u1; u0 < mask_.width; u0 = mask_.next_set(v, u1)) {
      u1 = mask_.next_clear(v, u0);
      if (run_count_ == static_cast<int>(runs_.size())) return {};
      const int id = run_count_++;
      int label = id;
      while (above < above_end && runs_[above].u1 < u0) ++above;  // touching corners count
      for (int k = above; k < above_end && runs_[k].u0 <= u1; ++k) {
        const int other = root(k);
        if (label != id && label != other)
          runs_[std::max(label, other)].label = static_cast<std::int16_t>(std::min(label, other));
        label = std::min(label, other);
      }
      runs_[id] = {static_cast<std::int16_t>(v), static_cast<std::int16_t>(u0),
                   static_cast<std::int16_t>(u1), static_cast<std::int16_t>(label), 0};
    }
    above_begin = begin;
    above_end = run_count_;
  }
  // The root of a component is its first run: top row, leftmost. Parents come before their runs.
  for (int i = 0; i < run_count_; ++i) {
    runs_[i].label = runs_[runs_[i].label].label;
    runs_[runs_[i].label].area += runs_[i].u1 - runs_[i].u0;
  }
  const auto larger = [](const Component& a, const Component& b) {
    return a.area != b.area ? a.area > b.area : a.label < b.label;
  };
  for (int i = 0; i < run_count_; ++i) {
    if (runs_[i].label != i || runs_[i].area < min_area) continue;
    Component c;
    c.label = i;
    c.area = runs_[i].area;
    if (component_count_ < kMaxComponents) {
      components_[component_count_++] = c;
    } else {
      auto smallest = std::max_element(components_, components_ + kMaxComponents, larger);
      if (larger(c, *smallest)) *smallest = c;
    }
  }
  std::sort(components_, components_ + component_count_, larger);
  for (int i = 0; i < component_count_; ++i) components_[i] = measure(components_[i].label);
  return {components_, static_cast<std::size_t>(component_count_)};
}

Component RegionFinder::measure(int label) noexcept {
  const Run& first = runs_[label];
  Component c{label,   first.area, Eigen::Vector2f::Zero(), first.u0, first.v, first.u1 - 1,
              first.v, first.u0};
  for (int i = label; i < run_count_; ++i) {
    const Run& r = runs_[i];
    if (r.label != label) continue;
    const int length = r.u1 - r.u0;
    c.centroid += Eigen::Vector2f(0.5f * (r.u0 + r.u1 - 1) * length, float(r.v) * length);
    c.u0 = std::min<int>(c.u0, r.u0);
    c.u1 = std::max<int>(c.u1, r.u1 - 1);
    c.v1 = r.v;
  }
  c.centroid /= static_cast<float>(c.area);
  return c;
}

const Component* RegionFinder::component_at(int u, int v) const noexcept {
  int best = -1;
  int best_distance = std::numeric_limits<int>::max();
  for (int i = 0; i < run_count_; ++i) {
    const Run& r = runs_[i];
    const int label = r.label;
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
    if (r.label != component.label) mask_.clear_run(r.v, r.u0, r.u1);
  }
}

Disc RegionFinder::deepest(const Component& c) noexcept {
  // Chamfer 3-4 distance at reduced resolution, without the scans along rows: the way to the
  // nearest pixel outside is either along the row or can begin with a step to the next one.
  const int box = std::max(c.u1 - c.u0, c.v1 - c.v0) + 1;
  const int step = std::max(1, box / kDeepestAcross);
  const int w = (c.u1 - c.u0) / step + 1, h = (c.v1 - c.v0) / step + 1, stride = w + 2;
  std::int16_t* const d = distance_.data();
  std::fill(d, d + static_cast<std::ptrdiff_t>(stride) * (h + 2), 0);
  std::int16_t* at = d;
  int begin = 0, end = 0;  // of pixels in a row that are inside
  const auto distances_along = [&] {
    for (int u = begin; u < end; ++u)
      at[u] = static_cast<std::int16_t>(3 * std::min(u - begin + 1, end - u));
  };
  // Other components may reach into the box: only this one's runs count. Its label is its first.
  for (int i = c.label; i < run_count_ && runs_[i].v <= c.v1; ++i) {
    const Run& r = runs_[i];
    if (r.label != c.label || (r.v - c.v0) % step != 0) continue;
    const int first = (r.u0 - c.u0 + step - 1) / step, last = (r.u1 - 1 - c.u0) / step;
    if (first > last) continue;
    std::int16_t* const row = d + ((r.v - c.v0) / step + 1) * stride + 1;
    if (row != at || first > end) {
      distances_along();
      at = row;
      begin = first;
    }
    end = last + 1;
  }
  distances_along();
  for (int v = 1; v <= h; ++v) distances_from(d + (v - 1) * stride + 1, w, d + v * stride + 1);
  Disc best;
  int deepest = 0;
  for (int v = h; v >= 1; --v) {
    std::int16_t* const row = d + v * stride + 1;
    distances_from(row + stride, w, row);
    std::int16_t most = 0;
    for (int u = 0; u < w; ++u) most = std::max(most, row[u]);
    if (most <= deepest) continue;
    deepest = most;
    int u = w - 1;
    while (row[u] != most) --u;
    best.center = Eigen::Vector2f(c.u0 + u * step, c.v0 + (v - 1) * step);
  }
  best.radius = deepest / 3.0f * step;
  return best;
}

}  // namespace handyar
