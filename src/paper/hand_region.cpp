// SPDX-License-Identifier: MIT
#include "paper/hand_region.hpp"

#include <algorithm>

#include "image/pixel_reader.hpp"

namespace handyar::paper {
namespace {

constexpr double kLeastShare = 0.01;  // of the picture: smaller regions are no hand

}  // namespace

void Mask::resize(int new_width, int new_height) {
  width = new_width;
  height = new_height;
  pixels.assign(static_cast<std::size_t>(width + 2) * (height + 2), 0);
}

void HandRegion::resize(int width_px, int height_px, int step) {
  step_ = step;
  mask_.resize(width_px / step, height_px / step);
  const std::size_t count = mask_.pixels.size();
  bins_.assign(count, 0);
  ratios_.assign(count, 0);
  labels_.assign(count, 0);
  distance_.assign(count, 0);
  stack_.reserve(count);
  hand_.reserve(count);
  background_.reserve(count);
}

void HandRegion::classify(const ImageView& frame, const SkinModel& skin) noexcept {
  const PixelReader reader(frame);
  for (int v = 0; v < mask_.height; ++v)
    for (int u = 0; u < mask_.width; ++u) {
      const int i = mask_.at_index(u, v);
      bins_[i] = reader.bin(u * step_, v * step_);
      ratios_[i] = skin.log_ratio(bins_[i]);
    }
  // A pixel is skin when it and its neighbours are, taken together: single pixels are noisy.
  const int row = mask_.width + 2;
  for (int v = 0; v < mask_.height; ++v)
    for (int u = 0; u < mask_.width; ++u) {
      const int i = mask_.at_index(u, v);
      const float sum =
          2 * ratios_[i] + ratios_[i - 1] + ratios_[i + 1] + ratios_[i - row] + ratios_[i + row];
      mask_.pixels[i] = sum > 0 ? 255 : 0;
    }
}

bool HandRegion::keep_largest() noexcept {
  std::fill(labels_.begin(), labels_.end(), 0);
  const int row = mask_.width + 2;
  int label = 0, best = 0;
  std::size_t best_area = 0;
  for (int v = 0; v < mask_.height; ++v)
    for (int u = 0; u < mask_.width; ++u) {
      const int start = mask_.at_index(u, v);
      if (mask_.pixels[start] == 0 || labels_[start] != 0) continue;
      ++label;
      std::size_t area = 0;
      stack_.clear();
      stack_.push_back(start);
      labels_[start] = label;
      while (!stack_.empty()) {
        const int i = stack_.back();
        stack_.pop_back();
        ++area;
        for (const int next : {i - 1, i + 1, i - row, i + row})
          if (mask_.pixels[next] != 0 && labels_[next] == 0) {
            labels_[next] = label;
            stack_.push_back(next);
          }
      }
      if (area <= best_area) continue;
      best_area = area;
      best = label;
      first_ = {u, v};
    }
  const auto size = static_cast<double>(mask_.width) * mask_.height;
  if (static_cast<double>(best_area) < kLeastShare * size) return false;
  for (std::size_t i = 0; i < labels_.size(); ++i) mask_.pixels[i] = labels_[i] == best ? 255 : 0;
  return true;
}

/// Chamfer distances to the background; the farthest pixel is the palm's middle.
void HandRegion::measure_distances() noexcept {
  constexpr std::int16_t kStraight = 3, kDiagonal = 4;
  const int row = mask_.width + 2;
  const auto nearer = [&](int i, int other, std::int16_t by) {
    distance_[i] =
        std::min<std::int16_t>(distance_[i], static_cast<std::int16_t>(distance_[other] + by));
  };
  for (int v = 0; v < mask_.height; ++v)
    for (int u = 0; u < mask_.width; ++u) {
      const int i = mask_.at_index(u, v);
      distance_[i] = mask_.pixels[i] != 0 ? 30000 : 0;
      if (distance_[i] == 0) continue;
      nearer(i, i - 1, kStraight);
      nearer(i, i - row, kStraight);
      nearer(i, i - row - 1, kDiagonal);
      nearer(i, i - row + 1, kDiagonal);
    }
  std::int16_t most = 0;
  for (int v = mask_.height - 1; v >= 0; --v)
    for (int u = mask_.width - 1; u >= 0; --u) {
      const int i = mask_.at_index(u, v);
      if (distance_[i] == 0) continue;
      nearer(i, i + 1, kStraight);
      nearer(i, i + row, kStraight);
      nearer(i, i + row + 1, kDiagonal);
      nearer(i, i + row - 1, kDiagonal);
      if (distance_[i] <= most) continue;
      most = distance_[i];
      palm_ = {static_cast<float>(u), static_cast<float>(v)};
    }
  palm_radius_ = static_cast<float>(most) / kStraight;
}

bool HandRegion::find(const ImageView& frame, const SkinModel& skin) noexcept {
  classify(frame, skin);
  if (!keep_largest()) return false;
  measure_distances();
  return true;
}

void HandRegion::collect_colors() noexcept {
  hand_.clear();
  background_.clear();
  constexpr std::int16_t kInside = 6;  // two pixels: edges are a mixture
  const int row = mask_.width + 2;
  for (int v = 2; v + 2 < mask_.height; ++v)
    for (int u = 2; u + 2 < mask_.width; ++u) {
      const int i = mask_.at_index(u, v);
      if (distance_[i] > kInside) hand_.push_back(bins_[i]);
      const bool near = mask_.pixels[i] != 0 || mask_.pixels[i - 2] != 0 ||
                        mask_.pixels[i + 2] != 0 || mask_.pixels[i - 2 * row] != 0 ||
                        mask_.pixels[i + 2 * row] != 0;
      if (!near) background_.push_back(bins_[i]);
    }
}

}  // namespace handyar::paper
