// SPDX-License-Identifier: MIT
#pragma once

#include "handyar/config.hpp"
#include "handyar/pose_filter.hpp"
#include "handyar/stages/align.hpp"

namespace handyar {

/// When a hand is believed. What a frame shows adds to the belief, its log odds of hand against no
/// hand, by the time it stands for.
struct BeliefConfig {
  double believe = 2.0;     ///< log odds from which on a hand is tracked; lost below minus that
  double most_frame = 4.0;  ///< no frame says more, either way, and no hand is believed more than
                            ///< by two such, so that it can be given up in time
  /// Frames err alike for so long: what they say counts by their time, the finder is asked this
  /// often about a hand that is followed surely, and one that is read otherwise is doubtful.
  double same_s = 0.2;
  /// Log ratio of a frame from which on a figure is seen to lie on a hand. Right ones have 6 to 9
  /// in dim rooms and more in others, those that have strayed about 4 and less (real clips).
  double seen = 5.0;
  /// A hand is doubtful that frames say less of in the mean, log odds, older ones fading in same_s:
  /// right hands in dim rooms dip for a frame or two, and what stands on them would flicker.
  double doubt = -1.0;
  /// And one whose figure has a smaller log ratio in one frame: figures that leap have 2 and less.
  double leaps = 3.0;
  double doubt_rad =
      0.2;  ///< a pose whose orientation is less sure (standard deviation) is doubtful

  double give_up() const { return -believe; }
  double most() const { return 2 * most_frame; }
};

/// How a hand moves from frame to frame, and how fingers do.
struct MotionConfig {
  double rotation_sigma_rad = 0.35;   ///< of a frame's pose around what the frames before foretell
  double translation_sigma_m = 0.06;  ///< the same
  double posture_s = 0.15;            ///< about as long a finger keeps its turn and its bend
  double boundary_sigma_px = 0.3;     ///< change of the outline's offset in a frame
};

/// How fast what is seen is learned.
struct LearningConfig {
  double colors_s = 0.15;  ///< colours on both sides of the outline fade this fast
  /// Of the time that a hand has been seen counts as one independent view of its figure, same_s at
  /// least. Views come back, and the figure's errors with them.
  double view_share = 0.2;
  double texture_s = 1.0;  ///< the look of the palm's skin fades this fast
};

/// All settings of the tracker, a struct per stage, after what the user asked for.
struct TrackerConfig {
  TrackerConfig(const Config& asked = {}) : user(asked) {
    filter.enabled = asked.smoothing > 0;
    if (!filter.enabled) return;
    filter.acceleration_m_s2 /= asked.smoothing;
    filter.acceleration_rad_s2 /= asked.smoothing;
  }

  Config user;
  AlignConfig align;
  BeliefConfig belief;
  MotionConfig motion;
  LearningConfig learning;
  PoseFilterConfig filter;
};

}  // namespace handyar
