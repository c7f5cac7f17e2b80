// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

#include "align/hand_view.hpp"
#include "handyar/stages/align.hpp"
#include "handyar/stages/hand_figure.hpp"

namespace handyar {

/// The finest segment of a line across the outline, at the hand.
inline constexpr double kFinestSegment_m = 0.00075;
/// What is nearer to the outline than so many segments may lie on either side of it.
inline constexpr int kEitherSide = 2;

/// A place on the outline by what carries it, so that it moves with the figure: on the tangent of
/// two discs, or, where both are the same, on a disc where its normal is.
struct OutlineAnchor {
  std::uint8_t a = 0, b = 0;                         ///< spheres
  std::int8_t side = 1;                              ///< of the tangent, looking from a to b
  float along = 0;                                   ///< 0 at a, 1 at b
  Eigen::Vector2f normal = Eigen::Vector2f::Zero();  ///< of a single disc's place
  float inside_px = 0, outside_px = 0;  ///< how far the figure, and the free ground, reach
  bool furrow = false;  ///< another finger lies against it: there is no ground, but a furrow
};

/// Where an anchor is, in pixels of the view.
struct OutlinePlace {
  Eigen::Vector2f px, normal;  ///< outwards
};

using OutlineDerivative = Eigen::Matrix<double, 1, kHandFreedoms>;
using PlaceDerivative = Eigen::Matrix<double, 2, kHandFreedoms, Eigen::RowMajor>;

/// Tapered capsules in a view, each pair of spheres that a hull has once.
struct Capsules {
  static constexpr int kMost = 64;  ///< a multiple of a vector's width
  alignas(32) std::array<float, kMost> x, y, dx, dy, length, inverse_length, slope, r0, dr;
};

/// Triangles in a view by their corners and the edges from each to the next.
struct Sheets {
  static constexpr int kMost = 32;
  std::array<std::array<float, kMost>, 3> x, y, dx, dy;
};

/// The figure projected into a view: discs, with derivatives by the state.
class Silhouette {
 public:
  static constexpr int kMaxAnchors = 192;
  using Anchors = std::array<OutlineAnchor, kMaxAnchors>;

  Silhouette(Appearance appearance, const HandState& state, const HandView& view) noexcept;

  /// Places on the visible outline, about `spacing_px` apart, that have enough of the hand and of
  /// free ground beside them to be seen, and between fingers that lie together. Returns how many.
  int choose(float spacing_px, Anchors& anchors) const noexcept;

  OutlinePlace place(const OutlineAnchor& anchor) const noexcept;

  /// Derivative of the outline's displacement along its normal there.
  OutlineDerivative derivative(const OutlineAnchor& anchor,
                               const OutlinePlace& place) const noexcept;

  /// A fingertip or a finger's root, and how they move.
  Eigen::Vector2f tip_px(int finger) const noexcept;
  Eigen::Vector2f root_px(int finger) const noexcept { return disc_px(sphere_of(finger, 0)); }
  PlaceDerivative tip_derivative(int finger) const noexcept;
  PlaceDerivative root_derivative(int finger) const noexcept;

  /// Distance of a point from the figure and the forearm, negative inside; px.
  float distance_px(const Eigen::Vector2f& p) const noexcept;

  /// Whether another part than this finger lies at a point.
  bool others_cover(int finger, const Eigen::Vector2f& p) const noexcept;

  /// Size of `length_m` at the hand.
  double to_px(double length_m) const noexcept { return f_px_ * length_m / depth_m_; }
  bool valid() const noexcept { return valid_; }

  /// The figure without the forearm, grown by `grow_px`, as overlapping convex polygons.
  static constexpr int kMostCorners = 24;
  template <class Take>
  void each_convex_piece(float grow_px, const Take& take) const {
    std::array<Eigen::Vector2f, kMostCorners> corners;
    for (int i = 0; i < own_capsules(); ++i)
      take(std::span(corners.data(), capsule_polygon(i, grow_px, corners)));
    for (int i = 0; i < sheet_count(); ++i)
      take(std::span(corners.data(), sheet_polygon(i, corners)));
  }

  Eigen::Vector2f disc_px(int sphere) const noexcept { return {x_[sphere], y_[sphere]}; }

 private:
  // Two spheres more than the figure: the forearm, which only hides.
  static constexpr int kDiscs = kSphereCount + 2;

  void project(const HandFigure& figure, const PosedFigure& posed, const HandState& state,
               const HandView& view) noexcept;
  void add_capsules() noexcept;
  void add_sheets() noexcept;
  static int own_capsules() noexcept;
  static int sheet_count() noexcept;
  std::size_t capsule_polygon(int capsule, float grow_px,
                              std::array<Eigen::Vector2f, kMostCorners>& corners) const noexcept;
  std::size_t sheet_polygon(int sheet,
                            std::array<Eigen::Vector2f, kMostCorners>& corners) const noexcept;
  float capsule_distance_px(int capsule, const Eigen::Vector2f& p) const noexcept;
  /// How a place moves that hangs on x, y and radius of a finger's sphere.
  PlaceDerivative place_derivative(int finger, int sphere,
                                   const Eigen::Matrix<double, 2, 3>& by_disc) const noexcept;
  /// Of a finger's last bone.
  Eigen::Vector2f direction(int finger) const noexcept;
  /// Takes a place, if it can be seen.
  bool try_anchor(OutlineAnchor anchor, Anchors& anchors, int& count) const noexcept;
  bool try_furrow(OutlineAnchor anchor, Anchors& anchors, int& count) const noexcept;
  /// Of the figure there, between the spheres that carry it.
  float thickness_px(const OutlineAnchor& anchor) const noexcept;

  bool valid_ = true;
  double f_px_ = 0, depth_m_ = 1;
  std::array<float, kDiscs> x_{}, y_{}, r_{};
  // Rows x, y, radius; columns rotation, translation, abduction and flexion of the sphere's finger,
  // the thumb's bend, figure.
  static constexpr int kOwnFigureAt = 9, kOwnFreedoms = kOwnFigureAt + kFigureModes;
  std::array<Eigen::Matrix<double, 3, kOwnFreedoms, Eigen::RowMajor>, kSphereCount> J_;
  Capsules capsules_;
  Sheets sheets_;
  int capsule_count_ = 0;
};

}  // namespace handyar
