// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <limits>
#include <span>
#include <vector>

#include "handyar/evaluation/statistics.hpp"
#include "handyar/evaluation/truth.hpp"
#include "handyar/tracker.hpp"

namespace handyar::evaluation {

inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// A hand is wrongly tracked where a fingertip is off by more than this share of the distance from
/// thumb tip to little tip: in sequences, clips and photographs, in the program and in its tests.
inline constexpr double kWrongOfSpan = 0.2;

inline constexpr int kWarmUpFrames = 25;  ///< given for acquisition at a sequence's beginning
inline constexpr double kRegain_s = 0.4;  ///< given after the five tips came into view

/// How long something has been in view without a break.
class InView {
 public:
  /// Whether it is in this frame, and has been for kRegain_s.
  bool add(bool seen, double time_s);

 private:
  double since_s_ = kUnknown;
};

/// Tracked fingertips against the true ones.
struct TipErrors {
  std::array<double, kFingerCount> px = {kUnknown, kUnknown, kUnknown, kUnknown, kUnknown};
  double span_px = kUnknown;  ///< from the true thumb tip to the true little one

  /// Whether all five are known and none is off by over kWrongOfSpan.
  bool right() const;
};

TipErrors tip_errors(const std::array<Tip, kFingerCount>& tips, const TipsPx& truth_px);

/// A pose against the true one; NaN where there is no pose.
struct PoseError {
  double rotation_deg = kUnknown;
  double translation_mm = kUnknown;
  double translation_percent = kUnknown;  ///< of the distance
  /// Normalised estimation error squared: error^T covariance^-1 error. Six on average when the
  /// stated covariance is honest.
  double nees = kUnknown;
};

/// One frame of a track against truth.
struct FrameError {
  bool eligible = false;  ///< the five tips are visible and were so long enough to be found
  bool no_open_hand = false;
  bool visible = false;        ///< the five tips are visible now
  bool tracked = false;        ///< state `tracking`
  bool on_other_hand = false;  ///< tracked, and rightly so, is a second hand
  bool wrong = false;          ///< tracked, but neither hand rightly
  bool layout_right = false;
  TipErrors tips;
  double tilt_deg = kUnknown, distance_mm = kUnknown;
  PoseError raw, filtered;
  double board_raw_px = kUnknown;  ///< rms at the board's corners, hand-to-board known from truth
  double board_filtered_px = kUnknown;
  double palm_px = kUnknown;  ///< of the middle of the palm, by the filtered pose
  /// Mean over the fingers, where they live.
  double abduction_deg = kUnknown, flexion_deg = kUnknown;

  bool right() const { return tracked && !wrong && !on_other_hand; }
  /// Whether the frame's errors count: rightly tracked when it should be.
  bool counted() const { return eligible && right(); }
};

/// Lays poses of the hand model that was used on the true hand: a calibrated model's frame on the
/// true one by the best rigid fit of the five tips, and a hand of assumed scale made as large as
/// the true one, fingertips about their mean.
class TrueHand {
 public:
  TrueHand(const Truth& truth, const HandModel& model);

  /// By how much lengths are multiplied; 1 for a measured hand.
  double scale() const { return scale_; }
  Eigen::Isometry3d T_camera_hand(const TruthFrame& frame, Eigen::Isometry3d T_camera_model) const;

 private:
  double scale_;
  Eigen::Isometry3d T_model_hand_;
};

/// Errors of a track, as the hand came to be known, one a frame of the track; frames that truth
/// does not know are left empty.
std::vector<FrameError> compare(const Truth& truth, const HandModel& hand,
                                std::span<const TrackResult> track);

/// What the errors of a sequence come to, over the frames that count.
struct Accuracy {
  int frames = 0, eligible = 0, tracked = 0, wrong = 0, layout_wrong = 0;
  int on_other_hand = 0;
  int no_open_hand = 0, falsely_tracked = 0;
  Summary tip_px, tip_of_span;
  std::array<Summary, kFingerCount> finger_px;
  Summary rotation_deg, rotation_raw_deg, translation_mm, translation_raw_mm, translation_percent;
  Summary board_px, board_raw_px, palm_px;
  Summary abduction_deg, flexion_deg;
  double palm_within_8px = kUnknown;  ///< share
  Summary nees, nees_raw;
  double nees_within_95 = kUnknown, nees_raw_within_95 = kUnknown;  ///< share; honest: 0.95

  double tracked_percent() const { return eligible ? 100.0 * tracked / eligible : kUnknown; }
  double wrong_percent() const { return tracked ? 100.0 * wrong / tracked : kUnknown; }
};

Accuracy summarize(std::span<const FrameError> errors);

}  // namespace handyar::evaluation
