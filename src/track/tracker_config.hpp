// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <numeric>

#include "handyar/config.hpp"
#include "handyar/pose_filter.hpp"
#include "handyar/stages/align.hpp"

namespace handyar {

/// When a hand is believed. What a frame shows adds to the belief, its log odds of hand against no
/// hand, by the time it stands for.
struct BeliefConfig {
  double believe = 2.0;  ///< log odds from which on a hand is tracked; lost below minus that
  /// Frames are alike for about so long, and err alike: what they say counts by their time, fingers
  /// keep their turn and bend, and colours fade. The finder is asked this often about a hand that
  /// is followed surely, and one that is read otherwise is doubtful for so long.
  double same_s = 0.2;
  /// A figure is laid as well as it can be on anything: it speaks for a hand only from this log
  /// ratio on, and less than it claims. In dim rooms right ones have hardly more; from 5 on, a hand
  /// that shows four fingers is tracked in 24 of 3240 frames, from 7 on in none.
  double even = 7.0, claim = 0.4;
  /// A pose whose orientation is less sure (standard deviation) is doubtful, and two ways to see a
  /// hand that are nearer to each other are one.
  double doubt_rad = 0.2;

  double give_up() const { return -believe; }
  /// A hand is doubtful that frames say less of in the mean, log odds, older ones fading in same_s:
  /// right hands in dim rooms dip for a frame or two, and what stands on them would flicker. A
  /// figure that says less is not seen to lie on the hand: those that have strayed have a log ratio
  /// of about 4 and less (real clips).
  double doubt() const { return give_up() / 2; }
  /// No frame says more, either way.
  double most_frame() const { return 2 * believe; }
  /// No hand is believed more, so that it can be given up in time.
  double most() const { return 2 * most_frame(); }
  /// What a frame's log ratio says of a hand, log odds.
  double says(double log_ratio) const { return claim * (log_ratio - even); }
  /// What a figure says of there being an open hand, log odds: its outline or the colours inside,
  /// whichever say less, for the outline of a door's handle may be a hand's. One that lacks a part
  /// speaks against it as loudly as a frame can.
  double evidence_of(const Alignment& alignment, const PartRatios& inside) const {
    if (!is_whole(alignment, inside)) return -most_frame();
    const double of_inside = std::accumulate(inside.begin(), inside.end(), 0.0);
    return std::clamp(says(std::min(alignment.log_ratio, of_inside)), -most_frame(), most_frame());
  }
  /// Log ratio of a frame from which on a figure is seen to lie on a hand.
  double seen() const { return even + doubt() / claim; }
};

/// How a hand moves from frame to frame.
struct MotionConfig {
  double rotation_sigma_rad = 0.35;   ///< of a frame's pose around what the frames before foretell
  double translation_sigma_m = 0.06;  ///< the same
  double boundary_sigma_px = 0.3;     ///< change of the outline's offset in a frame
};

/// How fast what is seen is learned.
struct LearningConfig {
  /// So long a hand is remembered: the look of its skin fades this fast, what its figure does not
  /// explain stays, one that is lost may come back, and another way to see it is thought of this
  /// often.
  double remember_s = kRemembered_s;
};

/// All settings of the tracker, a struct per stage, after what the user asked for.
struct TrackerConfig {
  TrackerConfig(const Config& asked = {}) : user(asked) {
    filter.enabled = asked.smoothing > 0;
    if (!filter.enabled) return;
    constexpr double kLeastSmoothing = 1e-3;  // the filter's numbers lose their meaning below
    const double smoothing = std::max(asked.smoothing, kLeastSmoothing);
    filter.acceleration_m_s2 /= smoothing;
    filter.acceleration_rad_s2 /= smoothing;
  }

  Config user;
  BeliefConfig belief;
  MotionConfig motion;
  LearningConfig learning;
  PoseFilterConfig filter;
};

}  // namespace handyar
