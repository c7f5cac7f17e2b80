// SPDX-License-Identifier: MIT
#include "handyar/contour.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace handyar {

void Contour::reserve(int max_points) {
  points_.resize(max_points);
  arc_.resize(max_points + 1);
  prefix_.resize(max_points + 1);
}

bool Contour::trace(const Mask& mask, const Component& component) noexcept {
  // Directions clockwise on the screen, from east: du, dv.
  static constexpr int kDu[8] = {1, 1, 0, -1, -1, -1, 0, 1};
  static constexpr int kDv[8] = {0, 1, 1, 1, 0, -1, -1, -1};

  size_ = 0;
  int u = component.first_u, v = component.v0;
  int direction = 0, first_direction = -1;
  arc_[0] = 0;
  prefix_[0].setZero();
  do {
    // The pixel before this one in clockwise order around it is background: search from there.
    int d = (direction + 6) & 7, tries = 0;
    while (tries < 8 && !mask.at(u + kDu[d], v + kDv[d])) {
      d = (d + 1) & 7;
      ++tries;
    }
    if (tries == 8) break;  // a single pixel
    if (u == component.first_u && v == component.v0 && d == first_direction)
      break;  // about to repeat the first step
    if (first_direction < 0) first_direction = d;
    if (size_ == static_cast<int>(points_.size())) return false;
    points_[size_] = {static_cast<std::int16_t>(u), static_cast<std::int16_t>(v)};
    prefix_[size_ + 1] = prefix_[size_] + Eigen::Vector2i(u, v);
    arc_[size_ + 1] = arc_[size_] + ((d & 1) != 0 ? std::numbers::sqrt2_v<float> : 1.0f);
    ++size_;
    u += kDu[d];
    v += kDv[d];
    direction = d;
  } while (true);
  return size_ >= 8;
}

bool Contour::trace(const Mask& mask) noexcept {
  Component only;
  for (only.v0 = 0; only.v0 < mask.height; ++only.v0) {
    only.first_u = mask.next_set(only.v0, 0);
    if (only.first_u < mask.width) return trace(mask, only);
  }
  size_ = 0;
  return false;
}

int Contour::index_at(float arc) const noexcept {
  const float length = perimeter();
  arc -= length * std::floor(arc / length);
  const auto after = std::upper_bound(arc_.begin(), arc_.begin() + size_, arc);
  return std::clamp(static_cast<int>(after - arc_.begin()) - 1, 0, size_ - 1);
}

int Contour::resample(float spacing, float window, std::span<Eigen::Vector2f> out) const noexcept {
  const int count =
      std::clamp(static_cast<int>(perimeter() / spacing), 8, static_cast<int>(out.size()));
  const float step = perimeter() / static_cast<float>(count);
  const int half = std::clamp(static_cast<int>(0.5f * window), 0, size_ / 2 - 1);
  const auto mean_around = [&](int i) -> Eigen::Vector2f {
    const int a = i - half, b = i + half + 1;
    Eigen::Vector2i sum = prefix_[std::min(b, size_)] - prefix_[std::max(a, 0)];
    if (a < 0) sum += prefix_[size_] - prefix_[size_ + a];
    if (b > size_) sum += prefix_[b - size_];
    return sum.cast<float>() / static_cast<float>(2 * half + 1);
  };
  int i = 0;
  for (int k = 0; k < count; ++k) {
    const float arc = k * step;
    while (i + 1 < size_ && arc_[i + 1] <= arc) ++i;
    const float f = (arc - arc_[i]) / (arc_[i + 1] - arc_[i]);
    out[k] = (1 - f) * mean_around(i) + f * mean_around((i + 1) % size_);
  }
  return count;
}

}  // namespace handyar
