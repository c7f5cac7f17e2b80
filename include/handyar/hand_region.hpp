// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "handyar/color_bins.hpp"
#include "handyar/hand_model.hpp"
#include "handyar/mask.hpp"

namespace handyar {

/// The prior of each pixel's place, for squares of `cell` pixels: added to its ratio (eighths of a
/// nat). By default nothing.
struct ExpectedRegion {
  static constexpr std::int8_t kInside = 1,
                               kOutside = -32;  ///< inside adds nothing; outside is no hand
  int cell = 1 << 14, columns = 1;
  std::vector<std::int8_t> ratios = {0};  ///< row by row

  bool one_for_all() const noexcept { return columns == 1; }
  const std::int8_t* row(int v) const noexcept { return ratios.data() + v / cell * columns; }
};

/// Where the parts of a hand are expected, in mask pixels.
struct ExpectedHand {
  struct Finger {
    Eigen::Vector2f base, tip;
  };
  Eigen::Vector2f palm;
  float finger_width;
  std::array<Finger, kFingerCount - 1> fingers;  ///< without the thumb, which wears no ring
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

  /// Room for masks of up to `max_pixels` pixels in frames of up to `max_side` pixels a side.
  void reserve(int max_pixels, int max_side = 4096);

  /// mask = what was classified elsewhere.
  void classify(const Mask& mask) noexcept { mask_.copy(mask); }

  /// mask = ratio of the bin, averaged over 3x3 pixels, and of the place together > 0. Outside the
  /// hand's inside, edges in the picture cut the region, so that it does not run out into what has
  /// the hand's colour.
  void classify(const BinView& image, std::span<const std::int8_t> ratios,
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

  /// Segmentation of a hand (paper 2.1) that is about where it is expected: mask = the component at
  /// its palm alone, fingers included that a ring has cut off. Null when nothing of at least
  /// `min_area` pixels is there.
  const Component* segment(const BinView& image, std::span<const std::int8_t> ratios,
                           const ExpectedRegion& expected, const ExpectedHand& hand,
                           int min_area) noexcept;

  /// Clears all other components from the mask.
  void keep_only(const Component& component) noexcept;

  /// Largest disc inside a component (distance transform at reduced size).
  Disc deepest(const Component& component) noexcept;

  const Mask& mask() const noexcept { return mask_; }

 private:
  void expect_row(const ExpectedRegion& expected, int v) noexcept;
  /// The component at the palm alone, with the fingers that join() gives it.
  const Component* component_of(const ExpectedHand& hand, int min_area) noexcept;
  /// Where a ring has cut the end of a finger off the component of that label: bridges the gap, if
  /// it is shorter than a finger is wide, in the mask. True when there was one.
  bool join(const ExpectedHand::Finger& finger, float finger_width, int label) noexcept;
  /// Of the component that holds `p`, after components(); -1: none.
  int label_at(const Eigen::Vector2f& p) const noexcept;
  struct Run {
    std::int16_t v, u0, u1;  ///< u0 <= u < u1
    std::int16_t label;      ///< union-find parent, then component label
    std::int32_t area;       ///< of the component, in the run that is its label
  };
  int root(int run) noexcept;
  Component measure(int label) noexcept;

  Mask mask_;
  Mask colored_;  ///< the mask before edges cut it
  Mask opened_, scratch_;
  std::vector<std::int16_t> rows_[3];             ///< three rows of horizontally summed ratios
  std::vector<std::int16_t> looked_up_;           ///< ratios of one row, with one more at each end
  std::vector<std::int16_t> limits_, per_level_;  ///< what the places of a row ask for
  std::vector<std::uint8_t> flags_, colored_flags_;  ///< a row of the masks before it is packed
  std::vector<Run> runs_;
  int run_count_ = 0;
  Component components_[kMaxComponents];
  int component_count_ = 0;
  std::vector<std::int16_t> distance_;
};

}  // namespace handyar
