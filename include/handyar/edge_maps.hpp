// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <vector>

#include "handyar/color_bins.hpp"

namespace handyar {

/// A picture at a reduced size as bytes that tell where an edge of each direction is near, a faint
/// one nearly as much as a strong one, and where none is. After the gradient response maps of
/// Hinterstoisser et al. (PAMI 2012). Around the picture lies a margin, for what is cut by its
/// border.
class EdgeMaps {
 public:
  static constexpr int kDirections = 8;      ///< of half a turn; each has a map
  static constexpr int kCalm = kDirections;  ///< the map of where there is no edge
  static constexpr int kMaps = kDirections + 1;
  static constexpr int kMost = 63;   ///< of a map: four together fit a byte
  static constexpr int kBlock = 16;  ///< so many bytes behind the last map may be read

  EdgeMaps();

  /// Room for images of up to `max_pixels` bins and `max_side` bins a side, at 1/least_scale of
  /// their size or less.
  void reserve(int max_pixels, int max_side, float least_scale);

  /// Reads `image` at 1/scale of its size, scale from 1 to 32. False when there is no room for
  /// that.
  bool read(const BinView& image, float scale) noexcept;

  // Sizes in pixels of the maps, with the margin. The even columns of a map lie together, row by
  // row, then the odd ones: every second place can be read in one go.
  int width() const noexcept { return width_; }
  int height() const noexcept { return height_; }
  int row_size() const noexcept { return width_ / 2; }
  int offset(int map, int x, int y) const noexcept {
    return (2 * map + (x & 1)) * row_size() * height_ + y * row_size() + (x >> 1);
  }
  const std::uint8_t* data() const noexcept { return maps_.data(); }

  /// The map of edges across `normal`, not zero.
  int nearest_direction(const Eigen::Vector2f& normal) const noexcept {
    const Eigen::Vector2f g = normal * (kTableReach / normal.cwiseAbs().maxCoeff());
    const Edge& e = edge_in_table(static_cast<int>(g.x()), static_cast<int>(g.y()));
    return e.next_strength > e.strength ? (e.direction + 1) % kDirections : e.direction;
  }

  /// 0 to kMost: how much of an edge across `normal` is at a point of the maps.
  int edge_at(const Eigen::Vector2f& p, const Eigen::Vector2f& normal) const noexcept {
    const int x = static_cast<int>(p.x() + 0.5f), y = static_cast<int>(p.y() + 0.5f);
    if (x < 0 || y < 0 || x >= width_ || y >= height_) return kBeyond;
    return maps_[offset(nearest_direction(normal), x, y)];
  }

  /// An affine map into the image for one into the maps, and the other way round.
  Eigen::Matrix<float, 2, 3> to_image(Eigen::Matrix<float, 2, 3> map) const noexcept {
    map *= scale_;
    map.col(2).array() += image_offset();
    return map;
  }
  Eigen::Matrix<float, 2, 3> from_image(Eigen::Matrix<float, 2, 3> map) const noexcept {
    map.col(2).array() -= image_offset();
    return map / scale_;
  }

 private:
  /// What a colour step from one neighbour to the other means: shares of two directions.
  struct Edge {
    std::uint8_t direction, strength, next_strength, calm;
  };

  static constexpr int kMargin = 12;      // pixels
  static constexpr int kBeyond = 6;       // what it holds: about what a picture holds
  static constexpr int kTableReach = 63;  // of the table of edges; larger differences are halved
  float image_offset() const noexcept { return scale_ * (0.5f - kMargin) - 0.5f; }
  const Edge& edge_in_table(int gx, int gy) const noexcept {
    return edge_table_[(gy + kTableReach) * (2 * kTableReach + 1) + gx + kTableReach];
  }
  const Edge& edge(int gx, int gy) const noexcept;
  void read_colors(const BinView& image, int width, int height) noexcept;
  void find_edges(int v, int width, int height, std::uint8_t* to) noexcept;
  void spread(int map) noexcept;

  float scale_ = 1;
  int width_ = 0, height_ = 0;
  std::size_t room_ = 0;  // pixels
  std::vector<Edge> edge_table_;
  std::vector<std::uint8_t> colors_;  // three channels of the reduced image
  std::vector<std::uint8_t> maps_;
  // Of a row:
  std::vector<std::int16_t> steps_x_, steps_y_;
  std::vector<std::uint8_t> directions_, strengths_, next_strengths_, columns_, highest_;
};

}  // namespace handyar
