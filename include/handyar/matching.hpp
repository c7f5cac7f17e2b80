// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

#include "handyar/fingertips.hpp"
#include "handyar/hand_model.hpp"

namespace handyar {

struct MatchingConfig {
  double max_displacement = 0.3;  ///< of a tip relative to the centroid, over the thumb-little span
  int min_tips = 4;               ///< fewer matched tips: no match
  float min_valley_depth = 0.25f;  ///< between matched neighbours, in palm radii
};

/// Which candidate is which finger; -1 where none is.
using TipAssignment = std::array<int, kFingerCount>;

/// Frame-to-frame matching (paper 2.3, equation 2): among the assignments of candidates to fingers
/// that keep the order of the fingers along the contour, the one with the least total squared
/// displacement, positions taken relative to the region's centroid.
///
/// `previous` and `candidates` are relative to their frame's centroid; `candidates` are in
/// clockwise order. `gate_px` is the displacement at which a finger is rather taken to be missing.
TipAssignment match_tips(const std::array<Eigen::Vector2f, kFingerCount>& previous,
                         std::span<const Eigen::Vector2f> candidates, Layout layout,
                         float gate_px) noexcept;

}  // namespace handyar
