// SPDX-License-Identifier: MIT
// A tree of footage, judged as a user feels it: the default method on every sequence, and how its
// figures are distributed over sequences, since a thousand good frames of one room do not make up
// for a room in which no hand is found.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "handyar/evaluation/accuracy.hpp"
#include "handyar/evaluation/sequence.hpp"

namespace handyar::evaluation {

/// A video of a tree: of a folder with video.mp4 (a rendered one has truth.json there), or named in
/// an open_frames.csv beside it (columns clip, frame, open, thumb_x ... little_y in pixels).
struct Footage {
  std::string group;  ///< the folder above, from the tree's root
  Sequence sequence;
  /// By frame; of a clip that a list names. Without this and without truth nothing can be judged.
  std::optional<std::map<int, TipsPx>> open_tips_px;
};

/// All of a tree, in the order of their paths. Throws io::Error, also when there is none.
std::vector<Footage> find_footage(const std::filesystem::path& tree,
                                  const SequenceOptions& options);

/// What one video comes to. Open frames: those in which five outstretched fingers have been in view
/// for 0.4 s (in rendered ones also not among the first 25 frames).
struct FootageFigures {
  std::string group, name;
  int frames = 0, open_frames = 0, right = 0, wrong = 0;
  int right_as_sound = 0, wrong_as_sound = 0;  ///< of these, those not said to be doubtful
  int on_other_hand = 0;                       ///< open frames in which a second hand is tracked
  /// Of a clip without open frames all that its list does not name open.
  int handless_frames = 0, falsely_tracked = 0;
  int state_changes = 0;  ///< between open frames
  int shown_changes = 0;  ///< between these, how often an object on the hand comes or goes
  /// Of two frames in a row that are shown as sound (tracked, not doubtful): how often the hand
  /// leaps by more than a fifth of its distance.
  int jumps = 0;
  /// Shown as sound, though there truly is no open hand, or the pose is off by more than 25 degrees
  /// or a fifth of the distance; empty without truth.
  std::optional<int> unsound;
  Summary rotation_deg, translation_percent, tip_of_span;
  Summary abduction_deg, flexion_deg;  ///< mean of the five fingers, where they live
  double palm_within_8px = kUnknown, nees_within_95 = kUnknown;  ///< shares
  double tracking_ms = kUnknown, searching_ms = kUnknown;        ///< medians
  std::string worst_caption;
  std::vector<unsigned char> worst_jpeg;
  std::string broken_off;  ///< why the video ended early; empty: it did not

  double right_percent() const { return open_frames ? 100.0 * right / open_frames : kUnknown; }
  double wrong_percent() const { return open_frames ? 100.0 * wrong / open_frames : kUnknown; }
};

/// A clip that a list names is begun `begins` times, from as many places in its first three fifths,
/// and all that is tracked then counts: where a hand is begun is chance, and much hangs on it.
FootageFigures measure(const Footage& footage, int begins = 1);

/// Writes sequences.csv, distribution.md and worst-1.jpg to worst-5.jpg into the folder, in place
/// of an earlier run's report; returns the text of distribution.md. Throws io::Error.
std::string write_distribution(const std::string& folder,
                               const std::vector<FootageFigures>& figures);

}  // namespace handyar::evaluation
