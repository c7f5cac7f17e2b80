// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "handyar/color_bins.hpp"

namespace handyar {

/// Binary image with a border of one zero pixel on every side, so that neighbours always exist.
struct Mask {
  int width = 0, height = 0;  ///< without the border
  std::vector<std::uint8_t> pixels;

  int stride() const noexcept { return width + 2; }
  std::uint8_t* row(int v) noexcept { return pixels.data() + (v + 1) * stride() + 1; }
  const std::uint8_t* row(int v) const noexcept { return pixels.data() + (v + 1) * stride() + 1; }
  bool at(int u, int v) const noexcept { return row(v)[u] != 0; }
  /// The pixel in which a point lies is set; false outside.
  bool holds(const Eigen::Vector2f& p) const noexcept {
    const int u = static_cast<int>(std::lround(p.x())), v = static_cast<int>(std::lround(p.y()));
    return u >= 0 && v >= 0 && u < width && v < height && at(u, v);
  }
};

/// What a pixel's place says beforehand, for squares of `cell` pixels: added to its ratio (eighths
/// of a nat). By default nothing.
struct ExpectedRegion {
  static constexpr std::int8_t kInside = 1,
                               kOutside = -32;  ///< inside adds nothing; outside is no hand
  int cell = 1 << 14, columns = 1;
  std::vector<std::int8_t> ratios = {0};  ///< row by row

  const std::int8_t* row(int v) const noexcept { return ratios.data() + v / cell * columns; }
};

/// A connected component (8 neighbours) of a mask, in mask pixels.
struct Component {
  int label = 0;
  int area = 0;
  Eigen::Vector2f centroid = Eigen::Vector2f::Zero();
  int u0 = 0, v0 = 0, u1 = 0, v1 = 0;  ///< bounding box, inclusive
  int first_u = 0;                     ///< its leftmost pixel in its top row v0
};

/// The deepest point of a component: centre and radius of the largest disc inside it.
struct Disc {
  Eigen::Vector2f center = Eigen::Vector2f::Zero();
  float radius = 0;
};

/// Hand region (paper 2.1): thresholding and connected components by runs, all in fixed memory.
class RegionFinder {
 public:
  static constexpr int kMaxComponents = 32;

  /// Room for masks of up to `max_pixels`.
  void reserve(int max_pixels);

  /// mask = ratio of the bin > threshold (eighths of a nat).
  void classify(const BinImage& image, std::span<const std::int8_t> ratios, int threshold) noexcept;

  /// mask = ratio of the bin, averaged over 3x3 pixels, and of the place together > 0. Outside the
  /// hand's inside, edges in the picture cut the region, so that it does not run out into what has
  /// the hand's colour.
  void classify(const BinImage& image, std::span<const std::int8_t> ratios,
                const ExpectedRegion& expected) noexcept;

  /// Removes what is thinner than 2 * radius + 1 pixels (lines, specks, frayed edges) and leaves
  /// the rest as it is: the opening by a square, grown back by one pixel more inside the mask.
  void remove_thin(int radius) noexcept;

  /// Gives the mask back what edges have cut off: up to `radius` pixels around it, where colour and
  /// place say hand.
  void grow_back(int radius) noexcept;

  /// Finds the components of at least `min_area` pixels, largest first, at most kMaxComponents.
  std::span<const Component> components(int min_area) noexcept;

  /// The component that holds (u, v) or else the one nearest to it; null when there is none.
  const Component* component_at(int u, int v) const noexcept;

  /// Clears all other components from the mask.
  void keep_only(const Component& component) noexcept;

  /// Largest disc inside a component (distance transform at reduced size).
  Disc deepest(const Component& component) noexcept;

  const Mask& mask() const noexcept { return mask_; }

 private:
  struct Run {
    std::int16_t v, u0, u1;  ///< u0 <= u < u1
    std::int32_t label;      ///< union-find parent, then component label
  };
  void resize_mask(int width, int height) noexcept;   ///< and clears its border
  std::uint8_t* copy_with_room(int radius) noexcept;  ///< of the mask, zeros before and behind
  std::int32_t root(std::int32_t run) noexcept;

  Mask mask_;
  std::vector<std::int16_t> rows_[3];  ///< three rows of horizontally summed ratios
  std::vector<Run> runs_;
  int run_count_ = 0;
  std::vector<Component> totals_;  ///< one per root run
  Component components_[kMaxComponents];
  int component_count_ = 0;
  std::vector<std::uint16_t> distance_;
  std::vector<std::uint8_t> colored_;  ///< the mask before edges cut it
  std::vector<std::uint8_t> opened_;
};

}  // namespace handyar
