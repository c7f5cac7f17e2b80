// SPDX-License-Identifier: MIT
// Where a hand is that is not followed: the tracker's part of acquisition (paper 2.2).
#include "tracker_impl.hpp"

namespace handyar {

/// The whole frame at reduced size, by shape (paper 2.2). True when `shape` is new: a hand, or one
/// more like a hand than the one that is being acquired.
bool HandTracker::Impl::find_anywhere(const ImageView& frame) noexcept {
  read(frame, {0, 0, width_px, height_px}, search_step(), config.noise.searched, 1);
  HandShape coarse;
  found_again.reset();
  if (!search.find(bins, skin, coarse)) return false;
  const BinView& seen = search.image();
  const HandShape candidate =
      coarse.transformed(static_cast<float>(seen.step_px), seen.origin_px());
  if (following && state == State::acquiring) {
    if (candidate.resembles(shape)) {
      acquired_deviation = std::min(acquired_deviation, candidate.deviation);
      found_again = candidate;
      return false;
    }
    if (candidate.deviation > config.acquisition.takeover_share * acquired_deviation) return false;
  }
  go_to(candidate);
  // Found by another reading, the hand is in a light that what was learned does not tell about.
  if (search.found_by_skin())
    skin.restore(trusted_skin);
  else
    skin.reset();
  skin.forget_background();
  skin.widen();
  learn(seen, search.mask(), coarse);
  return true;
}

/// Where the search saw what may be any hand's outline but no region: true when it is the outline
/// of the hand that was lost, not far from there and about as large.
bool HandTracker::Impl::find_own_outline() noexcept {
  if (!may_go_by_outline()) return false;
  for (const HandShape& proposal : search.outlines().proposals()) {
    if (proposal.layout != own_shape.layout()) continue;
    HandShape hand = own_shape.laid_on(proposal);
    if (!to_input(hand).may_follow(shape) ||
        search.outlines().follow(bins, hand) < config.acquisition.sure_support)
      continue;
    go_to(to_input(hand));
    return true;
  }
  return false;
}

/// The candidate is where to look, until forget_found().
void HandTracker::Impl::go_to(const HandShape& candidate) noexcept {
  before_search.shape = shape;
  before_search.following = following;
  following = following && state == State::lost && candidate.may_follow(shape);
  if (!following) velocity_px_s.setZero();
  shape = candidate;
}

/// What the search found was no hand at a closer look: the last place counts again, and the colours
/// of when a hand was last tracked.
void HandTracker::Impl::forget_found() noexcept {
  shape = before_search.shape;
  following = before_search.following;
  skin.restore(trusted_skin);
}

/// What the search found, as it saw it: leaves what segment() leaves.
bool HandTracker::Impl::adopt_found(const ImageView& frame) noexcept {
  const BinView& seen = search.image();
  const int step = seen.step_px;
  read(frame, {seen.x0_px, seen.y0_px, seen.width * step, seen.height * step}, step,
       config.noise.searched, 1);
  before = expected = to_mask(shape);
  colorless = false;
  return trace(search.mask());
}

}  // namespace handyar
