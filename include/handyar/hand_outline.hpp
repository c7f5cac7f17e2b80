// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "handyar/edge_maps.hpp"
#include "handyar/hand_shape.hpp"
#include "handyar/mask.hpp"

namespace handyar {

/// The outline of a hand in its own plane, drawn from its tips and valleys: bones with flesh around
/// them. It is laid over the edges of a picture, moved and bent until most of it lies on edges.
class HandOutline {
 public:
  using AffineMap = Eigen::Matrix<float, 2, 3>;
  /// `at_m` in metres of the hand's plane; the hand ends towards `normal`.
  struct Point {
    Eigen::Vector2f at_m, normal;
    int bone;  ///< a finger's number, or beyond
  };
  /// How far a finger is turned, and stretched, while its place is looked for.
  struct Bends {
    std::span<const float> turns_rad, lengths;
  };
  struct BentFinger {
    Eigen::Vector2f tip_m = Eigen::Vector2f::Zero();
    float support = 0;  ///< 0 to 1: how much edge lies under the finger
  };

  HandOutline();

  /// Of a hand as HandShape::in_hand_plane() gives it. Takes no memory.
  void draw(const HandShape& hand_m) noexcept;

  const HandShape& hand_m() const noexcept { return hand_; }
  std::span<const Point> points() const noexcept { return points_; }

  /// 0 to 1: how much edge lies under the outline where `maps_hand` puts it.
  float support(const EdgeMaps& edges, const AffineMap& maps_hand) const noexcept;

  /// Moves the hand without turning it to where most edge is, by up to `reach` pixels of the maps
  /// each way, in steps of two.
  void shift(const EdgeMaps& edges, int reach, AffineMap& maps_hand) const noexcept;

  /// Moves the hand as a whole to where most edge is; by steps of two pixels, a tenth of a radian
  /// and a tenth of the size, times each of `steps` in turn.
  void align(const EdgeMaps& edges, std::span<const float> steps,
             AffineMap& maps_hand) const noexcept;

  /// The way to bend one finger that puts most edge under it.
  BentFinger bend(const EdgeMaps& edges, const AffineMap& maps_hand, int finger,
                  const Bends& bends) const noexcept;

 private:
  int edges_under(const EdgeMaps& edges, const AffineMap& maps_hand) const noexcept;

  HandShape hand_;
  std::vector<Point> points_;
};

/// Sets the pixels of the mask that the hand covers, in its pixels: what an outline encloses.
void draw_silhouette(const HandShape& hand, Mask& mask) noexcept;

}  // namespace handyar
