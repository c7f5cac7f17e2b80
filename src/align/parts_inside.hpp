// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "align/hand_view.hpp"
#include "align/outline_colors.hpp"
#include "align/silhouette.hpp"
#include "handyar/stages/align.hpp"
#include "image/color_bin.hpp"

namespace handyar {

/// Points inside a part: along a finger's axis, or spread over the palm.
inline constexpr int kMostInside = 16;

/// What the picture shows inside one part of a figure.
struct PartInside {
  std::array<ColorBin, kMostInside> bins{};
  int count = 0;    ///< of bins: points in the picture where no other part lies
  int covered = 0;  ///< points where another part lies, too: they tell nothing of this one

  /// Too little of it is in the picture to tell anything.
  bool unknown() const noexcept { return 2 * (count + covered) < kMostInside; }
  bool folded() const noexcept { return count < covered; }
};
using PartsInside = std::array<PartInside, OutlineColors::kParts>;

/// What the picture shows inside the figure of a state, whose silhouette is valid.
PartsInside parts_inside(const ImageView& frame, const Camera& camera, const HandView& view,
                         const Silhouette& silhouette, Appearance appearance,
                         const HandState& state) noexcept;

/// Log likelihood ratios of hand against none, nats, each part's by the colours of the rest.
PartRatios ratios_of(const PartsInside& parts, const OutlineColors& colors) noexcept;

}  // namespace handyar
