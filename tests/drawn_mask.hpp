// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "handyar/contour.hpp"
#include "handyar/hand_region.hpp"

namespace handyar::test {

/// A mask drawn by a predicate over its pixels, with the stages that read it.
struct DrawnMask {
  /// `inside(u, v)`: whether the centre of pixel (u, v) belongs to the mask.
  template <class Inside>
  DrawnMask(int width, int height, const Inside& inside) {
    std::vector<std::uint8_t> pixels;
    for (int v = 0; v < height; ++v)
      for (int u = 0; u < width; ++u) pixels.push_back(inside(u, v) ? 255 : 0);
    Mask mask;
    mask.pack(pixels.data(), width, height, width);
    region.reserve(width * height);
    region.classify(mask);
    contour.reserve(1 << 15);
  }

  /// The largest component, its contour traced; false when there is none.
  bool trace_largest() {
    const auto components = region.components(1);
    if (components.empty()) return false;
    largest = components[0];
    return contour.trace(region.mask(), largest);
  }

  RegionFinder region;
  Component largest;
  Contour contour;
};

/// A stroke with round ends. In plain numbers: drawing hands is most of what the tests compute.
class Capsule {
 public:
  Capsule(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double radius)
      : ax_(a.x()),
        ay_(a.y()),
        along_x_(b.x() - ax_),
        along_y_(b.y() - ay_),
        squared_length_(along_x_ * along_x_ + along_y_ * along_y_),
        radius_(radius) {}

  /// Signed distance of a point: negative inside.
  double distance(double x, double y) const {
    const double dx = x - ax_, dy = y - ay_;
    const double s = std::clamp((dx * along_x_ + dy * along_y_) / squared_length_, 0.0, 1.0);
    const double off_x = dx - s * along_x_, off_y = dy - s * along_y_;
    return std::sqrt(off_x * off_x + off_y * off_y) - radius_;
  }

 private:
  double ax_, ay_, along_x_, along_y_, squared_length_, radius_;
};

/// Signed distance of `p` to a stroke of the given radius from `a` to `b`: negative inside.
inline double capsule_distance(const Eigen::Vector2d& p, const Eigen::Vector2d& a,
                               const Eigen::Vector2d& b, double radius) {
  return Capsule(a, b, radius).distance(p.x(), p.y());
}

}  // namespace handyar::test
