// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "handyar/color_bins.hpp"
#include "handyar/hand_region.hpp"
#include "handyar/hand_shape.hpp"

namespace handyar {

/// Colours of a frame in which the hand was verified: of what surely shows it, and of what around
/// it surely does not. In fixed memory.
struct SkinSamples {
  static constexpr int kMax = 8192;  ///< of each
  std::vector<ColorBin> hand, background;

  SkinSamples() {
    hand.reserve(kMax);
    background.reserve(kMax);
  }
};

/// Takes samples by the geometry of `shape` (pixels of `image` and `mask`, which are of one size).
/// Background is what cannot be the hand and, where its `mask` is known, what lies outside it, but
/// for what looks like the nails of a dark hand.
void sample_skin(const BinView& image, const Mask* mask, const HandShape& shape,
                 SkinSamples& samples) noexcept;

}  // namespace handyar
