// SPDX-License-Identifier: MIT
#include "skin_samples.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

namespace handyar {
namespace {

/// A word of row v: pixels that are set or have one two pixels away across or up.
std::uint64_t near_region(const Mask& mask, int v, int word) {
  const std::uint64_t *row = mask.row(v) + word, at = row[0];
  const std::uint64_t before = word > 0 ? row[-1] : 0, after = row[1];
  return at | at << 2 | at >> 2 | before >> 62 | after << 62 | mask.row(v - 2)[word] |
         mask.row(v + 2)[word];
}

float luma(ColorBin bin) { return static_cast<float>(ycbcr_of(bin)[0]); }
float redness(ColorBin bin) { return static_cast<float>(ycbcr_of(bin)[2]); }

template <class Value>
float mean(std::span<const ColorBin> bins, const Value& value) {
  float sum = 0;
  for (const ColorBin bin : bins) sum += value(bin);
  return sum / std::max(1.0f, static_cast<float>(bins.size()));
}

/// The nails of a dark hand are lighter than it, and a hand whose nails were taken for background
/// ends before them.
class Nails {
 public:
  /// Of a hand that has colours like these.
  Nails(const HandShape& shape, std::span<const ColorBin> hand) noexcept
      : radius_(0.5f * shape.finger_width) {
    constexpr float kDark = 80, kRed = 2, kLighter = 1.3f;  // dark skin, no glove
    hand_luma_ = mean(hand, luma);
    least_luma_ = hand_luma_ < kDark && mean(hand, redness) > kRed ? kLighter * hand_luma_ : 256;
    for (int f = 0; f < kFingerCount; ++f)
      centres_[f] =
          shape.tips[f] + radius_ * (shape.tips[f] - shape.finger_base(f)).stableNormalized();
  }

  /// Goes to row v.
  void enter(int v) noexcept {
    count_ = 0;
    for (const Eigen::Vector2f& centre : centres_) {
      const float up = static_cast<float>(v) - centre.y(), half2 = radius_ * radius_ - up * up;
      if (half2 > 0) in_row_[count_++] = {centre.x(), std::sqrt(half2)};
    }
  }
  /// Pixel u of the row, beyond the hand as far as it is known, shows one.
  bool hold(ColorBin bin, int u) const noexcept {
    return luma(bin) > least_luma_ &&
           std::any_of(in_row_.begin(), in_row_.begin() + count_, [u](const Span& span) {
             return std::abs(static_cast<float>(u) - span.middle) < span.half;
           });
  }
  /// A hand before this background is dark itself, not only in the dark.
  bool stand_out(std::span<const ColorBin> background) const noexcept {
    constexpr float kBrighter = 1.8f;
    return mean(background, luma) > kBrighter * hand_luma_;
  }

 private:
  struct Span {
    float middle, half;
  };
  float radius_, hand_luma_, least_luma_;
  std::array<Eigen::Vector2f, kFingerCount> centres_;  // of discs just beyond the tips
  std::array<Span, kFingerCount> in_row_;
  int count_ = 0;
};

}  // namespace

void sample_skin(const BinView& image, const Mask* mask, const HandShape& shape,
                 SkinSamples& samples) noexcept {
  samples.hand.clear();
  samples.background.clear();
  const auto take = [&](const Eigen::Vector2f& p) {
    if (!(p.x() >= 0) || !(p.y() >= 0)) return;
    const int u = static_cast<int>(p.x() + 0.5f), v = static_cast<int>(p.y() + 0.5f);
    if (u >= image.width || v >= image.height) return;
    if (samples.hand.size() < SkinSamples::kMax) samples.hand.push_back(image.at(u, v));
  };
  // Inside by geometry rather than by the mask, so that a mask that leaked teaches nothing.
  const float spacing = std::max(1.0f, shape.finger_width / 8);
  const float core = 0.3f * shape.finger_width;
  for (int f = 0; f < kFingerCount; ++f) {
    const Eigen::Vector2f from = shape.finger_base(f), to = shape.tips[f];
    const float length = (to - from).norm();
    const Eigen::Vector2f along = (to - from) / std::max(length, 1.0f);
    const Eigen::Vector2f across(-along.y(), along.x());
    for (float s = 0; s < length - core; s += spacing)
      for (float w = -core; w <= core; w += spacing) take(from + s * along + w * across);
  }
  const float palm = 0.85f * shape.palm_radius();
  for (float y = -palm; y <= palm; y += 1.5f * spacing)
    for (float x = -palm; x <= palm; x += 1.5f * spacing)
      if (x * x + y * y < palm * palm) take(shape.palm() + Eigen::Vector2f(x, y));
  Eigen::AlignedBox2f around = shape.bounds();
  around.extend(Eigen::Vector2f(around.min() - Eigen::Vector2f::Constant(shape.palm_radius())));
  around.extend(Eigen::Vector2f(around.max() + Eigen::Vector2f::Constant(shape.palm_radius())));
  const int grid = std::max({2, static_cast<int>(shape.finger_width / 5),
                             static_cast<int>(std::sqrt(around.volume() / SkinSamples::kMax)) + 1});
  const int u0 = std::max(grid, int(around.min().x())), v0 = std::max(grid, int(around.min().y()));
  const int u1 = std::min(image.width - grid, int(around.max().x()));
  const int v1 = std::min(image.height - grid, int(around.max().y()));
  const HandReach reach(shape);
  std::optional<Nails> nails;  // beyond a hand that was only searched for, nothing is known
  if (mask != nullptr) nails.emplace(shape, samples.hand);
  const auto hand_count = static_cast<std::ptrdiff_t>(samples.hand.size());
  for (int v = v0; v < v1; v += grid) {
    const ColorBin* const row = image.row(v);
    if (nails) nails->enter(v);
    std::uint64_t near = ~std::uint64_t{0};
    for (int u = u0, word = -1; u < u1; u += grid) {
      if (mask != nullptr && u >> 6 != word) near = near_region(*mask, v, word = u >> 6);
      // What hangs together with the hand and yet cannot be a part of it is background too.
      if ((near >> (u & 63) & 1) != 0 && reach.holds({float(u), float(v)})) continue;
      if (nails && nails->hold(row[u], u)) {
        if (samples.hand.size() < SkinSamples::kMax) samples.hand.push_back(row[u]);
        continue;
      }
      if (samples.background.size() == SkinSamples::kMax) break;
      samples.background.push_back(row[u]);
    }
  }
  // In dim light any hand is dark.
  const auto nail = samples.hand.begin() + hand_count;
  if (nail == samples.hand.end() || nails->stand_out(samples.background)) return;
  const auto room = static_cast<std::ptrdiff_t>(SkinSamples::kMax - samples.background.size());
  samples.background.insert(samples.background.end(), nail,
                            nail + std::min(room, samples.hand.end() - nail));
  samples.hand.erase(nail, samples.hand.end());
}

}  // namespace handyar
