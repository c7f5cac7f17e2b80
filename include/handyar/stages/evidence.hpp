// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "handyar/stages/align.hpp"
#include "handyar/stages/hand_finder.hpp"
#include "handyar/tracker.hpp"

namespace handyar {

/// What a frame showed, for pictures and for finding out why.
struct FrameEvidence {
  std::span<const HandCandidate> candidates;  ///< where the finder saw hands, if it looked
  std::span<const OutlinePoint> outline;      ///< the figure's outline, as aligned
  double log_ratio = 0;  ///< log likelihood ratio of a hand there against none, this frame alone
  double belief = 0;     ///< log odds, added up over time
  int hypotheses = 0;    ///< appearances and planar solutions still thought possible
};

/// The posture in which a result has the hand; at rest where there is none.
Posture posture_of(const TrackResult& result) noexcept;

}  // namespace handyar
