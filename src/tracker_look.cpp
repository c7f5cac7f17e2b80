// SPDX-License-Identifier: MIT
// In which ways, and in which order, a frame is looked at for the hand.
#include <algorithm>

#include "tracker_impl.hpp"

namespace handyar {

/// One frame. Each look is true when it shows the hand, and then `found`, `component` and the
/// result tell of it.
class HandTracker::Impl::Look {
 public:
  Look(Impl& tracker, const ImageView& frame, const StageClock& clock, TrackResult& result) noexcept
      : t_(tracker), frame_(frame), clock_(clock), result_(result) {}

  bool at_hand() noexcept {
    if (t_.state == State::acquiring && search() && anew()) return true;
    if (t_.following && (near(false) || at_outline(false))) return true;
    if (t_.state == State::acquiring && t_.found_again) return as_found(*t_.found_again);
    if (t_.state != State::searching && t_.state != State::lost) return false;
    return search() ? anew() : at_own_outline();
  }

 private:
  bool search() noexcept {
    return segmentation([&] { return t_.find_anywhere(frame_); });
  }

  /// What the search finds is rough: its colours are learned and the hand is looked at again. If
  /// that does not tell it from what surrounds it, what the search saw must do.
  bool anew() noexcept {
    const HandShape candidate = t_.shape;
    bool seen = near(true);
    for (int again = 0; !seen && again < 2 && t_.promising; ++again) {
      t_.shape = t_.to_input(t_.found);
      t_.learn(t_.bins, t_.stages.region.mask(), t_.found);
      seen = near(true);
    }
    if (!seen && candidate.deviation < t_.config.shape.max_deviation) seen = as_found(candidate);
    if (seen)
      t_.acquired_deviation = candidate.deviation;
    else
      t_.forget_found();
    return seen;
  }

  /// As the search saw it.
  bool as_found(const HandShape& candidate) noexcept {
    t_.shape = candidate;
    return segmentation([&] { return t_.adopt_found(frame_); }) && identify(true);
  }

  /// By colour alone; unless that is surely a hand, by place and edges too: the more hand-like
  /// wins.
  bool near(bool anew) noexcept {
    if (!segmentation([&] { return t_.read_neighbourhood(frame_, anew); })) return false;
    const bool seen = at_colors(anew, false);
    const HandShape first = t_.found;
    if (seen && first.deviation < t_.config.shape.sure_deviation) return true;
    const auto tips = [](const HandShape& hand) { return std::ranges::count(hand.tip_seen, true); };
    if (at_colors(anew, true) &&
        (!seen || (t_.found.deviation < first.deviation && tips(t_.found) >= tips(first))))
      return true;
    return seen && at_colors(anew, false);
  }

  bool at_colors(bool anew, bool where_expected) noexcept {
    return segmentation([&] { return t_.segment(where_expected); }) && identify(anew);
  }

  bool at_outline(bool anew) noexcept {
    return segmentation([&] { return t_.follow_outline(); }) && identify(anew);
  }

  /// Where a hand that was lost shows its outline again.
  bool at_own_outline() noexcept {
    if (!segmentation([&] { return t_.find_own_outline(); })) return false;
    if (segmentation([&] { return t_.read_neighbourhood(frame_, true); }) && at_outline(true))
      return true;
    t_.forget_found();
    return false;
  }

  /// The stages after segmentation.
  bool identify(bool anew) noexcept {
    StageTimes& times = result_.times;
    if (!clock_.time(times.fingertips_ms, [&] { return t_.find_fingertips(); })) return false;
    if (!clock_.time(times.matching_ms, [&] { return t_.match(anew); })) return false;
    clock_.time(times.fingertips_ms, [&] {
      t_.measure_tips(result_);
      t_.measure_axes(result_);
    });
    return clock_.time(times.pose_ms, [&] { return t_.estimate_pose(result_); });
  }

  template <class Stage>
  bool segmentation(const Stage& stage) noexcept {
    return clock_.time(result_.times.segmentation_ms, stage);
  }

  Impl& t_;
  const ImageView& frame_;
  const StageClock& clock_;
  TrackResult& result_;
};

bool HandTracker::Impl::look_at_hand(const ImageView& frame, const StageClock& clock,
                                     TrackResult& result) noexcept {
  return Look(*this, frame, clock, result).at_hand();
}

}  // namespace handyar
