// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "handyar/pose_filter.hpp"
#include "handyar/stages/align.hpp"
#include "handyar/stages/evidence.hpp"
#include "handyar/stages/hand_finder.hpp"
#include "handyar/tracker.hpp"
#include "track/gestures.hpp"
#include "track/hypotheses.hpp"
#include "track/person.hpp"
#include "track/tracker_config.hpp"

namespace handyar {

/// Palms that are nearer to each other than this share of a hand's reach are taken for one: open
/// hands would overlap. What is seen there is that hand, read alike or otherwise, and no other.
inline constexpr float kSamePalm = 0.8f;

/// All that the tracker knows from frame to frame; resetting it forgets everything.
struct TrackerState {
  double time_s = -std::numeric_limits<double>::infinity();
  State state = State::searching;
  double belief = 0;  ///< log odds of hand against no hand
  double lately = 0;  ///< what frames of late say of the hand in the mean, log odds
  double looked_s = -std::numeric_limits<double>::infinity();
  HandPlace place{};  ///< of the hand when it was last seen whole
  double tracked_s = -std::numeric_limits<double>::infinity();
  /// When the hand that was tracked was last read otherwise, or another one taken for it.
  double changed_s = -std::numeric_limits<double>::infinity();
  /// The finder's last look read the hand that is followed otherwise, and the picture not.
  bool read_otherwise = false;
  Hypotheses hypotheses;
  PartRatios inside{};  ///< what the colours inside the likeliest say
  Gestures gestures;
  Person person;         ///< as last learned; a new hand begins with it
  double learned_s = 0;  ///< for how long the person's figure has been learned
  PoseFilter filter;
  /// By which this hand is told from another, and whether the two that share a view met and have
  /// not been seen apart since.
  Appearance own{};
  bool met = false;
};

struct HandTracker::Impl {
  Impl(const Camera& camera, const HandModel& hand, const Config& config);
  ~Impl() { share_view(nullptr); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  FrameStatus admit(const ImageView& frame, double time_s) noexcept;
  void follow(const ImageView& frame, double dt_s) noexcept;
  void compare_postures(const ImageView& frame, double dt_s) noexcept;
  void look(const ImageView& frame) noexcept;
  void believe(double dt_s) noexcept;
  void filter(double dt_s, TrackResult& result) noexcept;
  void learn(const ImageView& frame, double dt_s) noexcept;
  void report(TrackResult& result) noexcept;
  HandMask draw_mask() noexcept;
  /// Of the hand as it was laid last, before others are.
  void keep_outline() noexcept;
  /// The hand as this frame shows it, open or folded; null where there is none.
  const Hypothesis* in_view() const noexcept;
  void reset() noexcept;

  HandPlace place_of(const Hypothesis& its) const noexcept;
  HandPlace followed() const noexcept { return place_of(seen.hypotheses.best()); }
  /// How the finder reads the place where a hand is followed.
  enum class Reading { same, otherwise, elsewhere };
  Reading compare(const HandCandidate& candidate, const HandPlace& now) const noexcept;
  /// The hand that is followed as the finder sees it; null where it does not or reads it otherwise.
  const HandCandidate* seen_again() const noexcept;
  /// What the colours inside a figure say of its parts.
  PartRatios look_inside(const Hypothesis& its, const ImageView& frame,
                         const Aligner& by) const noexcept;
  /// Sets the candidates, those around a followed hand if it is surely seen there; returns it as
  /// seen_again does.
  const HandCandidate* find(const ImageView& frame) noexcept;
  void begin(const ImageView& frame) noexcept;

  /// Shares the view with one other tracker, or with none.
  void share_view(Impl* with) noexcept;
  bool has_hand() const noexcept { return seen.hypotheses.size() > 0; }
  /// Whether a hand is followed or was lost a short while ago.
  bool has_followed() const noexcept;
  /// Whether the followed hand is seen to lie where it is followed, whole.
  bool holds_hand() const noexcept;
  /// Whether a candidate is the hand that the other tracker follows.
  bool is_of_other(const HandCandidate& candidate) const noexcept;
  /// Whether a candidate is left to the other tracker, which has lost its hand or waits for one.
  bool is_for_other(const HandCandidate& candidate, Reading reading) const noexcept;
  /// Keeps by which layout this hand is told from the other's.
  void tell_from_other() noexcept;
  /// Whether the hand that is followed is the other's: it lies there and is explained better by the
  /// other tracker, or it has turned into the other's where they met.
  bool follows_hand_of_other() const noexcept;
  /// Whether it is time to search for a hand, while there is none.
  bool may_search() const noexcept;

  Impl* other = nullptr;  ///< whose hand is left alone, where two are followed
  bool leads = true;      ///< of two trackers without a hand this one searches

  TrackerConfig config;
  HandModel hand;            ///< as given
  Camera calibrated_camera;  ///< as given
  Camera camera;             ///< for frames of the present size
  HandFinder finder;
  Aligner aligner;
  Aligner scout;  ///< tries hands that the finder saw, with colours of their own
  TrackerState seen;

  // Of the last frame, for those who ask.
  std::span<const HandCandidate> candidates;
  FrameEvidence evidence;
  std::vector<OutlinePoint> outline;
  HandModel learned_hand;
  std::vector<std::uint8_t> mask;
};

}  // namespace handyar
