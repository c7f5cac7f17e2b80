// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "handyar/hand_region.hpp"

namespace handyar {

/// Closed outer boundary of a component, one point per boundary pixel, clockwise as seen on the
/// screen (the region lies to the right of the direction of travel).
class Contour {
 public:
  void reserve(int max_points);

  /// Follows the boundary (Moore neighbours). False when it is longer than there is room for, or a
  /// mere speck.
  bool trace(const Mask& mask, const Component& component) noexcept;
  /// The same for a mask of a single component; false when nothing is set, too.
  bool trace(const Mask& mask) noexcept;

  int room() const noexcept { return static_cast<int>(points_.size()); }
  int size() const noexcept { return size_; }
  /// Point i in mask pixels.
  Eigen::Vector2f operator[](int i) const noexcept {
    return {float(points_[i].u), float(points_[i].v)};
  }
  /// Length along the boundary from point 0 to point i; i = size() gives the whole.
  float arc_length(int i) const noexcept { return arc_[i]; }
  float perimeter() const noexcept { return arc_[size_]; }

  /// Index of the point at a given arc length (wraps around).
  int index_at(float arc) const noexcept;

  /// Points spaced evenly by about `spacing` mask pixels, each the mean over `window` pixels of
  /// boundary, which takes the stairs out of it. Returns how many were written to `out`; the
  /// spacing grows where `out` would be too small.
  int resample(float spacing, float window, std::span<Eigen::Vector2f> out) const noexcept;

 private:
  struct Point {
    std::int16_t u, v;
  };
  std::vector<Point> points_;
  std::vector<float> arc_;
  std::vector<Eigen::Vector2i> prefix_;  ///< running sums of the points
  int size_ = 0;
};

}  // namespace handyar
