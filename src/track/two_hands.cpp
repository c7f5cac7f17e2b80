// SPDX-License-Identifier: MIT
#include <algorithm>

#include "track/tracker_state.hpp"

namespace handyar {

void HandTracker::Impl::share_view(Impl* with) noexcept {
  if (other != nullptr && other != with) other->other = nullptr;
  other = with;
}

bool HandTracker::Impl::is_of_other(const HandCandidate& candidate) const noexcept {
  if (other == nullptr || other->in_view() == nullptr) return false;
  Eigen::Vector2f among_tips_px = Eigen::Vector2f::Zero();
  for (const Eigen::Vector2f& tip_px : candidate.tips_px) among_tips_px += tip_px / kFingerCount;
  // Where fingers are half closed the palm is ill told by their tips, which then lie about it.
  const auto distance = [&](const HandPlace& its) {
    return std::min((candidate.palm_px - its.palm_px).norm(),
                    (among_tips_px - its.palm_px).norm()) /
           its.reach_px();
  };
  Hypothesis open = *other->in_view();  // as large as when its fingers are not folded
  open.alignment.state.posture = {};
  const float from_other = distance(place_of(open));
  return from_other < kSamePalm && !(holds_hand() && distance(followed()) < from_other);
}

bool HandTracker::Impl::has_followed() const noexcept {
  return seen.state == State::tracking || seen.state == State::lost;
}

bool HandTracker::Impl::is_for_other(const HandCandidate& candidate,
                                     Reading reading) const noexcept {
  if (other == nullptr || other->holds_hand()) return false;
  if (holds_hand()) return reading == Reading::elsewhere || other->has_followed();
  return other->has_followed() && candidate.layout == other->seen.own.layout &&
         candidate.layout != seen.own.layout;
}

void HandTracker::Impl::tell_from_other() noexcept {
  if (other != nullptr && other->has_hand()) {
    const HandPlace its = other->followed();
    seen.met = (followed().palm_px - its.palm_px).norm() < its.reach_px();
  } else if (other == nullptr || !other->has_followed()) {
    seen.met = false;
  }
  // What strays over an empty room turns over as it likes.
  if (!seen.met && holds_hand()) seen.own = seen.hypotheses.best().appearance;
}

bool HandTracker::Impl::follows_hand_of_other() const noexcept {
  if (other == nullptr || !has_hand()) return false;
  const Layout layout = seen.hypotheses.best().appearance.layout;
  if (seen.met && layout != seen.own.layout && layout == other->seen.own.layout) return true;
  if (!other->has_hand()) return false;
  return followed().same_tips(other->followed()) && seen.belief < other->seen.belief;
}

bool HandTracker::Impl::may_search() const noexcept {
  if (other == nullptr) return true;
  if (other->in_view() == nullptr) return leads || seen.state == State::lost;
  return seen.state == State::lost || seen.time_s - seen.looked_s >= config.belief.same_s;
}

void share_view(HandTracker& first, HandTracker& second) noexcept {
  if (first.impl_ == second.impl_) return;
  first.impl_->share_view(second.impl_.get());
  second.impl_->share_view(first.impl_.get());
  first.impl_->leads = true;
  second.impl_->leads = false;
}

}  // namespace handyar
