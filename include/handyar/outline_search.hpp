// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "handyar/color_bins.hpp"
#include "handyar/edge_maps.hpp"
#include "handyar/hand_outline.hpp"
#include "handyar/hand_shape.hpp"

namespace handyar {

struct OutlineSearchConfig {
  int directions_per_frame = 5;        ///< of 30 in which a hand may point; they take turns
  int proposals = 5;                   ///< places a frame that are worth a closer look, at most 16
  double least_finger_bins = 6.5;      ///< width of the thinnest fingers that are looked for
  double least_finger_support = 0.46;  ///< of each finger of a hand that is followed, see follow()
};

/// Where hands may be, by their outline alone, whatever their colours. The outline of the average
/// hand, turned, mirrored, foreshortened and at many sizes, is slid over the directions of the
/// picture's edges; inside the hand there should be few. After Hinterstoisser et al., "Gradient
/// Response Maps for Real-Time Detection of Textureless Objects" (PAMI 2012). The best places are
/// then aligned with the edges, first the whole hand, then finger by finger. A hand whose own
/// outline is known is followed in the same way.
class OutlineSearch {
 public:
  explicit OutlineSearch(const OutlineSearchConfig& config = {});

  /// Room for images of up to `max_pixels` bins and `max_side` bins a side; to follow a hand in a
  /// finer picture there is room around its expected place.
  void reserve(int max_pixels, int max_side);

  /// Begins with the first of the directions again.
  void reset() noexcept { turn_ = 0; }

  /// The places most like a hand, each far from the others, in bins of `image`. Valid until the
  /// next call.
  std::span<const HandShape> find(const BinView& image) noexcept;

  /// What find() gave last.
  std::span<const HandShape> proposals() const noexcept {
    return {found_.data(), static_cast<std::size_t>(proposal_count_)};
  }

  /// Moves a hand that is expected about here, in bins of `image`, to where most edge lies under
  /// its own outline. How much, from 0 to 1: about 0.7 where the hand is, 0.5 elsewhere; 0 when a
  /// finger has too little or the hand is too large for the room, and then it is not moved.
  float follow(const BinView& image, HandShape& hand) noexcept;

 private:
  static constexpr int kMaxProposals = 16;

  struct Feature {
    std::int8_t dx, dy;  ///< pixels of the maps
    std::uint8_t map;
  };
  struct Template {
    Eigen::Matrix2f px_per_m;  ///< maps from hand, thumb_right
    Layout layout = Layout::thumb_right;
    std::vector<Feature> features;
    int left = 0, right = 0, up = 0, down = 0;  ///< how far the features reach
  };
  struct Proposal {
    HandOutline::AffineMap image_hand;  ///< as slid
    Layout layout = Layout::thumb_right;
    std::array<Eigen::Vector2f, kFingerCount> slid_tips;
    int score = 0;
    bool aligned = false;
    HandShape shape;  ///< once it is aligned
  };

  float least_scale() const noexcept;
  void make_templates();
  void slide(const Template& t) noexcept;
  void propose(const Template& t, const Eigen::Vector2f& at_px, int score) noexcept;
  HandShape align(const Proposal& slid) const noexcept;

  OutlineSearchConfig config_;
  HandOutline average_, own_;
  EdgeMaps edges_;
  std::vector<Template> templates_;  // those of one direction next to each other
  std::vector<std::uint16_t> sums_;
  std::vector<int> offsets_;
  std::array<Proposal, kMaxProposals> proposals_;
  std::array<HandShape, kMaxProposals> found_;
  int proposal_count_ = 0;
  int turn_ = 0;
};

}  // namespace handyar
