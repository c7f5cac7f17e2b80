// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>

#include "handyar/gesture.hpp"
#include "track/hypotheses.hpp"

namespace handyar {

/// Tells an open hand from a fist and from one whose thumb is folded in. An open hand that is
/// tracked is remembered; when it no longer fits, its palm is laid on the picture with the fingers
/// in all three postures. One that the outline and the colours speak for leads, and carries the
/// palm along.
class Gestures {
 public:
  /// Looks at the next frame, in which `tracked` is the open hand as it is followed; null where
  /// none is.
  void update(const ImageView& frame, const Camera& camera, const Hypothesis* tracked, double dt_s,
              const TrackerConfig& config, Aligner& aligner) noexcept;

  /// Of another hand nothing is known.
  void forget() noexcept;

  /// What the hand does, once it did so for a while.
  Gesture gesture() const noexcept { return gesture_; }
  /// What this frame completed.
  std::optional<GestureEvent> event() const noexcept { return event_; }

  /// An open hand that fitted does not fit any more: it may be folding.
  bool watches() const noexcept { return watches_; }
  /// A folded posture leads.
  bool folded() const noexcept { return leader_ != Gesture::open; }
  /// It does, or the palm is where it was and no posture fits: no open hand is to be claimed.
  bool holds() const noexcept { return folded() || holds_; }
  /// The hand was folded and is open again in this frame.
  bool opened() const noexcept { return opened_; }
  /// The hand that is held, or has just been opened.
  const Hypothesis& hand() const noexcept { return hand_; }

  /// True of an open hand that explains the picture about as well as it did before it folded: it
  /// lacks less than what tells a hand from none.
  bool fits(const Alignment& open, const BeliefConfig& belief) const noexcept;

 private:
  static constexpr int kPostures = 3;
  const Alignment& laid(Gesture posture) const noexcept { return laid_[static_cast<int>(posture)]; }
  double ratio(Gesture posture) const noexcept { return laid(posture).log_ratio; }

  /// `keep`: of what is usual the share that stays.
  void remember(const Hypothesis& open, double keep) noexcept;
  void carry(Gesture posture, double dt_s, double keep) noexcept;
  /// The palm goes on as it went.
  void go_on(double dt_s) noexcept;
  void open() noexcept;
  void lay(const ImageView& frame, const Camera& camera, double dt_s, const TrackerConfig& config,
           Aligner& aligner) noexcept;
  /// The posture that explains the picture; open where none does surely.
  Gesture choose(const Hypothesis* tracked, const ImageView& frame, const Camera& camera,
                 const TrackerConfig& config, const Aligner& aligner) const noexcept;
  /// Aligner::ratios_inside where fingers would be if they were outstretched.
  PartRatios inside(const HandState& state, const ImageView& frame, const Camera& camera,
                    const Aligner& aligner) const noexcept;
  void lead(Gesture posture, double dt_s, double keep) noexcept;

  Hypothesis hand_;                        ///< as last seen, open or folded; moving as is usual
  std::array<Alignment, kPostures> laid_;  ///< on the last frame that was watched
  double usual_ratio_ = 0;                 ///< of the hand when it is open; 0: none was seen
  bool watches_ = false, holds_ = false, opened_ = false;
  Gesture leader_ = Gesture::open;
  double leads_s_ = 0;    ///< without a break
  double unclear_s_ = 0;  ///< since any posture fitted
  Gesture gesture_ = Gesture::open;
  std::optional<GestureEvent> event_;
};

}  // namespace handyar
