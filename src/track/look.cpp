// SPDX-License-Identifier: MIT
#include <algorithm>

#include "track/tracker_state.hpp"

namespace handyar {
namespace {

/// A look at a hand takes in so many reaches around it.
constexpr float kReaches = 3.9f;

FinderRegion around(const HandPlace& place) { return place.region(kReaches * place.reach_px()); }

}  // namespace

HandPlace HandTracker::Impl::place_of(const Hypothesis& its) const noexcept {
  const HandState& state = its.alignment.state;
  const PosedFigure posed = posed_figure(its.appearance, state);
  HandPlace now;
  const auto shown = [&](const Eigen::Vector3d& p) {
    return camera.project(state.T_camera_hand * p).cast<float>().eval();
  };
  now.palm_px = shown(Eigen::Vector3d::Zero());
  for (int f = 0; f < kFingerCount; ++f) now.tips_px[f] = shown(posed.tips_m.col(f));
  return now;
}

HandTracker::Impl::Reading HandTracker::Impl::compare(const HandCandidate& candidate,
                                                      const HandPlace& now) const noexcept {
  if ((candidate.palm_px - now.palm_px).norm() > kSamePalm * now.reach_px())
    return Reading::elsewhere;
  return candidate.same_tips(now) ? Reading::same : Reading::otherwise;
}

const HandCandidate* HandTracker::Impl::seen_again() const noexcept {
  const HandPlace now = followed();
  for (const HandCandidate& candidate : candidates)
    if (!is_of_other(candidate) && compare(candidate, now) == Reading::same) return &candidate;
  return nullptr;
}

const HandCandidate* HandTracker::Impl::find(const ImageView& frame) noexcept {
  if (!has_hand()) {
    const bool lost = seen.state == State::lost;
    candidates = finder.search(frame, lost ? std::optional(around(seen.place)) : std::nullopt);
    return nullptr;
  }
  candidates = finder.look(frame, around(followed()));
  const HandCandidate* const again = seen_again();
  if (again && again->log_odds > 0) return again;
  candidates = finder.search(frame);
  return seen_again();
}

void HandTracker::Impl::look(const ImageView& frame) noexcept {
  const BeliefConfig& limits = config.belief;
  if (seen.gestures.folded()) return;  // it opens without the finder
  const bool had = has_hand();
  const bool sure = holds_hand() && seen.state == State::tracking && !seen.read_otherwise;
  const double since_s = seen.time_s - seen.looked_s;
  if ((sure && since_s < limits.same_s) || (!had && !may_search())) return;
  seen.looked_s = seen.time_s;
  const HandCandidate* const again = find(frame);
  if (had) {
    // Unseen, or read otherwise: too tilted, or half hidden.
    const double says = again ? again->log_odds : limits.give_up();
    const double share = std::min(1.0, since_s / limits.same_s);
    seen.belief += share * std::clamp(says, -limits.most_frame(), limits.most_frame());
    seen.hypotheses.expect(says > 0 ? again : nullptr, camera, share, limits);
  }
  seen.read_otherwise = false;
  begin(frame);
}

void HandTracker::Impl::begin(const ImageView& frame) noexcept {
  const BeliefConfig& limits = config.belief;
  const bool held = holds_hand();
  const double followed_ratio = held ? seen.hypotheses.best().alignment.log_ratio : 0;
  const double belief =
      held ? seen.belief + limits.evidence_of(seen.hypotheses.best().alignment, seen.inside) : 0;
  for (const HandCandidate& candidate : candidates) {
    Reading reading = has_hand() ? compare(candidate, followed()) : Reading::elsewhere;
    // What is not seen to lie there is no reading to choose between.
    if (!held && reading == Reading::otherwise) reading = Reading::elsewhere;
    const bool same = reading == Reading::same;
    if ((held && same) || is_of_other(candidate) || is_for_other(candidate, reading) ||
        (reading == Reading::elsewhere && candidate.log_odds + limits.most_frame() < belief))
      continue;
    Hypotheses fresh = seen.hypotheses;
    if (!(same ? fresh.lay_anew(frame, camera, config, scout)
               : fresh.begin(candidate, frame, camera, seen.person, config, scout)))
      continue;
    // Laid where the followed hand is, the picture shows no other reading of it.
    if (reading == Reading::otherwise && place_of(fresh.best()).same_tips(followed())) continue;
    const Alignment& best = fresh.best().alignment;
    // Where an open hand may be folding, only another one is taken that is as good, and none where
    // it is: with colours learned from what lies there a missing thumb looks as good as any.
    if (seen.gestures.watches() && !seen.gestures.fits(best, limits)) continue;
    const PartRatios inside = look_inside(fresh.best(), frame, scout);
    // Of two readings of one hand the picture decides, of two hands the one that is believed more.
    const bool better = reading == Reading::otherwise
                            ? best.log_ratio > followed_ratio
                            : candidate.log_odds + limits.evidence_of(best, inside) > belief;
    if (!better) {
      seen.read_otherwise |= reading == Reading::otherwise && candidate.log_odds > 0;
      continue;
    }
    seen.hypotheses = fresh;
    seen.inside = inside;
    std::swap(aligner, scout);
    keep_outline();
    if (same) return;
    seen.read_otherwise = false;
    seen.lately = 0;
    seen.filter.reset();
    // Where a hand was a moment ago the same one is likelier than any in any picture.
    const bool comes_back = seen.state == State::lost && fresh.may_be(side_of(seen.own));
    seen.own = fresh.best().appearance;
    if (seen.state == State::tracking) seen.changed_s = seen.time_s;
    if (reading == Reading::elsewhere) {
      seen.belief = candidate.log_odds + (comes_back ? limits.believe : 0);
      seen.gestures.forget();
    }
    return;
  }
}

}  // namespace handyar
