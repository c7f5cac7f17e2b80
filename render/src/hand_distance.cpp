// SPDX-License-Identifier: MIT
#include "hand_distance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace handyar::render {

double distance_px(const HandMask& mask, const Eigen::Vector2d& px) {
  double best2 = std::numeric_limits<double>::infinity();
  const double half = 0.5 * (mask.step_px - 1);
  for (int v = 0; v < mask.height; ++v) {
    const double dy = mask.y0_px + v * mask.step_px + half - px.y();
    if (dy * dy >= best2) continue;
    const std::uint8_t* row = mask.data + v * mask.stride_bytes;
    for (int u = 0; u < mask.width; ++u) {
      if (!row[u]) continue;
      const double dx = mask.x0_px + u * mask.step_px + half - px.x();
      best2 = std::min(best2, dx * dx + dy * dy);
    }
  }
  return std::max(0.0, std::sqrt(best2) - half - 0.5);
}

}  // namespace handyar::render
