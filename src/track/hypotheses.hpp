// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <optional>

#include "handyar/camera.hpp"
#include "handyar/image_view.hpp"
#include "handyar/stages/align.hpp"
#include "handyar/stages/hand_finder.hpp"
#include "track/person.hpp"
#include "track/seen_fingers.hpp"
#include "track/tracker_config.hpp"

namespace handyar {

/// One way to see the hand: palm or back, and one of the two planar solutions.
struct Hypothesis {
  Appearance appearance;
  Alignment alignment;
  Person person;                       ///< as it sees them
  double log_weight = 0;               ///< evidence so far, nats
  bool leads = false;                  ///< it is the one that is reported
  std::optional<SeenFingers> fingers;  ///< as the finder last saw them
  double liveliness = 1;               ///< of its fingers
};

/// The ways to see the hand that are still possible; the one that is reported first. Empty: no
/// hand.
class Hypotheses {
 public:
  static constexpr int kMost = 4;

  int size() const { return count_; }
  const Hypothesis& best() const { return items_[0]; }
  /// Whether any is of that hand of a person.
  bool may_be(Side side) const noexcept {
    return std::any_of(items_.begin(), items_.begin() + count_,
                       [&](const Hypothesis& h) { return side_of(h.appearance) == side; });
  }
  void clear() { count_ = 0; }
  /// A hand that is seen in one way alone.
  void resume(const Hypothesis& hypothesis) noexcept;

  /// The likeliest ways to see a hand that the finder saw: both faces, fingers apart and side by
  /// side, both planar solutions. False when none of them can be laid on the picture.
  bool begin(const HandCandidate& candidate, const ImageView& frame, const Camera& camera,
             const Person& person, const TrackerConfig& config, Aligner& aligner) noexcept;

  /// Lays each anew from where it is, on colours that are taken there: they or the light changed.
  /// False when none can be.
  bool lay_anew(const ImageView& frame, const Camera& camera, const TrackerConfig& config,
                Aligner& aligner) noexcept;

  /// What a finder sees of the hand: where fingertips and roots are, for frames to come, and,
  /// `share` of what it says, which face. Null: nothing.
  void expect(const HandCandidate* seen, const Camera& camera, double share,
              const BeliefConfig& belief) noexcept;

  /// Lays each on the next frame, weighs them, drops the unlikely. False when none can be seen.
  bool follow(const ImageView& frame, const Camera& camera, double dt_s,
              const TrackerConfig& config, Aligner& aligner) noexcept;

  /// Thinks again, now and then, of the other face, where nobody told which it is, in the other
  /// planar solution: colours and figure are better known than when they were given up, and hands
  /// turn over.
  void reconsider(const ImageView& frame, const Camera& camera, double dt_s,
                  const TrackerConfig& config, Aligner& aligner) noexcept;

  /// How far the others lie from the best, each by its probability (second moment of the pose
  /// about it): what not knowing which of them is right adds to its covariance. With
  /// `average_size` as hands of that size.
  Matrix6d spread(bool average_size) const noexcept;

  /// Each takes what its own figure says of the person; `share` of it is new.
  void learn_person(double share, const TrackerConfig& config) noexcept;

 private:
  /// A hand near its edge may turn through it or back, and looks the same for a while.
  void consider_edge(const MotionConfig& motion) noexcept;

  /// Those that have come to the same become one; then sorts and prunes.
  void keep_likely(const BeliefConfig& belief) noexcept;
  /// Adds a way to see the hand, in the place of one that is nearly the same or of the least likely
  /// one where there is no room, unless these are likelier.
  void keep_distinct(const Hypothesis& hypothesis, const BeliefConfig& belief) noexcept;
  /// The one that leads first, unless another is likelier by as much as a hand is believed with,
  /// then the likeliest; what is less likely than the first by `most` nats is given up.
  void sort_and_prune(const BeliefConfig& belief) noexcept;

  std::array<Hypothesis, kMost> items_;
  int count_ = 0;
  double since_reconsidered_s_ = 0;
};

}  // namespace handyar
