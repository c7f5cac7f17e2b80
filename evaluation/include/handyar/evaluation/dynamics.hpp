// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "handyar/evaluation/accuracy.hpp"
#include "handyar/evaluation/board_error.hpp"

namespace handyar::evaluation {

/// The poses of a track where the five tips are visible and it tracks and is not wrong (also before
/// it must), laid on the true hand; `filtered` or raw. A hand that folds its fingers has no
/// pose to compare.
Poses right_poses(const Truth& truth, const HandModel& hand, std::span<const TrackResult> track,
                  std::span<const FrameError> errors, bool filtered);

/// How much a pose trembles while hand and camera are (nearly) still relative to each other:
/// standard deviation of its error about its mean, runs of at least eight frames taken together.
struct Jitter {
  int frames = 0;
  double translation_mm = kUnknown, rotation_deg = kUnknown;
};
Jitter jitter(const Truth& truth, const Poses& T_camera_hand);

/// How far a track lags behind truth (s): where the displacements over five frames of three points
/// of the hand (origin and 0.1 m along x and y) correlate best with the true ones. Empty when too
/// little moves.
std::optional<double> delay_s(const Truth& truth, const Poses& T_camera_hand);

/// What the five tips' coming into view, or a loss in plain view, was followed by.
struct Recovery {
  enum class Kind { first_sight, hidden_before, lost_in_view } kind;
  int frame;                      ///< from which on the hand could be tracked
  std::optional<double> after_s;  ///< until rightly tracked; empty: never while it could be
};
std::vector<Recovery> recoveries(const Truth& truth, std::span<const FrameError> errors);

}  // namespace handyar::evaluation
