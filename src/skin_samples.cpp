// SPDX-License-Identifier: MIT
#include "skin_samples.hpp"

#include <algorithm>
#include <cmath>

namespace handyar {

void sample_skin(const BinImage& image, const Mask* mask, const HandShape& shape,
                 SkinSamples& samples) noexcept {
  samples.hand.clear();
  samples.background.clear();
  const auto take = [&](const Eigen::Vector2f& p) {
    if (!(p.x() >= 0) || !(p.y() >= 0)) return;
    const int u = static_cast<int>(p.x() + 0.5f), v = static_cast<int>(p.y() + 0.5f);
    if (u >= image.width || v >= image.height) return;
    if (samples.hand.size() < samples.hand.capacity())
      samples.hand.push_back(image.bins[static_cast<std::size_t>(v) * image.width + u]);
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
  const auto region_near = [&](int u, int v) {
    return mask == nullptr || mask->at(u, v) || mask->at(u - 2, v) || mask->at(u + 2, v) ||
           mask->at(u, v - 2) || mask->at(u, v + 2);
  };
  for (int v = v0; v < v1; v += grid)
    for (int u = u0; u < u1; u += grid) {
      // What hangs together with the hand and yet cannot be a part of it is background too.
      if (region_near(u, v) && reach.holds({float(u), float(v)})) continue;
      if (samples.background.size() < samples.background.capacity())
        samples.background.push_back(image.bins[static_cast<std::size_t>(v) * image.width + u]);
    }
}

}  // namespace handyar
