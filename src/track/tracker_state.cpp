// SPDX-License-Identifier: MIT
#include "track/tracker_state.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace handyar {
namespace {

// What an aligned figure's log ratio says of there being a hand at all: a figure is laid as well as
// it can be on anything, so it speaks for a hand only from here on, and less than it claims.
constexpr double kEven = 10.5, kClaim = 0.4;
// The finder reads a hand that is followed otherwise when only the palms are as near as this share
// of the hand's reach.
constexpr float kSamePalm = 0.8f;

double evidence_of(const Alignment& alignment, const BeliefConfig& belief) {
  return std::clamp(kClaim * (alignment.log_ratio - kEven), -belief.most_frame, belief.most_frame);
}

// The part of the pose's covariance that is new in each frame; the rest comes from what the figure
// cannot explain and stays while the view does.
constexpr double kNoisePart = 0.05;

// The hand frame's origin hangs on how a person holds middle finger and thumb at rest, which the
// figure does not tell: where the fingertips were never measured it lies so far from where the
// average hand has it (standard deviations along x and y).
constexpr double kOriginX_m = 0.005, kOriginY_m = 0.006;

/// What the origin of a hand that was never measured adds to the covariance of its translation.
Eigen::Matrix3d origin_covariance(const Eigen::Isometry3d& T_camera_hand) {
  const Eigen::Matrix<double, 3, 2> origin =
      T_camera_hand.linear().leftCols<2>() * Eigen::Vector2d(kOriginX_m, kOriginY_m).asDiagonal();
  return origin * origin.transpose();
}

}  // namespace

HandTracker::Impl::Impl(const Camera& c, const HandModel& h, const Config& cfg)
    : config(cfg),
      hand(h),
      calibrated_camera(c),
      camera(c),
      aligner(config.align),
      scout(config.align),
      seen{.hypotheses = {},
           .gestures = {},
           .person = Person(estimate_figure(h)),
           .filter = PoseFilter(config.filter)},
      learned_hand(h) {}

void HandTracker::Impl::reset() noexcept {
  seen = {.hypotheses = {},
          .gestures = {},
          .person = Person(estimate_figure(hand)),
          .filter = PoseFilter(config.filter)};
  aligner.forget();
  scout.forget();
  candidates = {};
  evidence = {};
  learned_hand = hand;
}

FrameStatus HandTracker::Impl::admit(const ImageView& frame, double time_s) noexcept {
  const FrameStatus status = check(frame);
  if (status != FrameStatus::ok) return status;
  if (!std::isfinite(time_s) || !(time_s > seen.time_s)) return FrameStatus::time_not_increasing;
  if (frame.width_px != camera.width_px || frame.height_px != camera.height_px) {
    camera = calibrated_camera.scaled_to(frame.width_px, frame.height_px);
    seen.hypotheses.clear();
    seen.gestures = {};
    seen.belief = 0;
  }
  return FrameStatus::ok;
}

void HandTracker::Impl::follow(const ImageView& frame, double dt_s) noexcept {
  if (!seen.hypotheses.follow(frame, camera, dt_s, config, aligner) || follows_hand_of_other())
    seen.hypotheses.clear();
  tell_from_other();
  if (!has_hand()) return;
  const Hypothesis& best = seen.hypotheses.best();
  seen.whole = std::ranges::none_of(
      aligner.shares_of_hand(frame, camera, best.appearance, best.alignment.state), is_gone);
}

void HandTracker::Impl::compare_postures(const ImageView& frame, double dt_s) noexcept {
  Gestures& gestures = seen.gestures;
  const bool open = has_hand() && (seen.state == State::tracking || gestures.holds());
  gestures.update(frame, camera, seen.person, open ? &seen.hypotheses.best() : nullptr, dt_s,
                  config, aligner);
  if (gestures.folded()) seen.hypotheses.clear();
  if (gestures.opened()) {
    seen.hypotheses.resume(gestures.hand());
    seen.whole = true;
    seen.belief = config.belief.believe + config.belief.most_frame;
  }
}

const Hypothesis* HandTracker::Impl::in_view() const noexcept {
  if (seen.gestures.holds()) return &seen.gestures.hand();
  return has_hand() ? &seen.hypotheses.best() : nullptr;
}

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
    if (candidate.log_odds > 0 && !is_of_other(candidate) &&
        compare(candidate, now) != Reading::elsewhere)
      return &candidate;
  return nullptr;
}

double HandTracker::Impl::verdict() const noexcept {
  const HandPlace now = followed();
  double says = config.belief.give_up;  // unseen: it may be too tilted, or half hidden
  for (const HandCandidate& candidate : candidates) {
    if (is_of_other(candidate)) continue;
    const Reading reading = compare(candidate, now);
    if (reading == Reading::same) return candidate.log_odds;
    if (reading == Reading::otherwise && candidate.log_odds > 0) says = 0;
  }
  return says;
}

void HandTracker::Impl::find(const ImageView& frame, bool only_there) noexcept {
  if (only_there) {
    constexpr float kReaches = 3.9f;
    const HandPlace now = followed();
    candidates = finder.look(frame, now.region(kReaches * now.reach_px()));
    if (verdict() > 0) return;
  }
  candidates = finder.search(frame);
}

void HandTracker::Impl::look(const ImageView& frame) noexcept {
  const BeliefConfig& limits = config.belief;
  const bool had = has_hand();
  const bool folded = seen.gestures.gesture() != Gesture::open;
  const bool sure =
      folded || (holds_hand() && seen.state == State::tracking && !seen.read_otherwise);
  const double since_s = seen.time_s - seen.looked_s;
  if ((sure && since_s < limits.same_s) || (!had && !may_search())) return;
  seen.looked_s = seen.time_s;
  find(frame, had);
  if (had) {
    const double share = std::min(1.0, since_s / limits.same_s);
    seen.belief += share * std::clamp(verdict(), -limits.most_frame, limits.most_frame);
    seen.hypotheses.expect(seen_again(), camera, share, limits);
  }
  seen.read_otherwise = false;
  begin(frame);
}

void HandTracker::Impl::begin(const ImageView& frame) noexcept {
  const bool had = holds_hand();
  const double followed_ratio = had ? seen.hypotheses.best().alignment.log_ratio : 0;
  const double belief =
      had ? seen.belief + evidence_of(seen.hypotheses.best().alignment, config.belief) : 0;
  for (const HandCandidate& candidate : candidates) {
    const Reading reading = had ? compare(candidate, followed()) : Reading::elsewhere;
    if (reading == Reading::same || is_of_other(candidate) || is_for_other(candidate, reading) ||
        (reading == Reading::elsewhere && candidate.log_odds + config.belief.most_frame < belief))
      continue;
    Hypotheses fresh;
    if (!fresh.begin(candidate, frame, camera, seen.person, config, scout)) continue;
    // Laid where the followed hand is, the picture shows no other reading of it.
    if (reading == Reading::otherwise && place_of(fresh.best()).same_tips(followed())) continue;
    const Alignment& best = fresh.best().alignment;
    // Where an open hand may be folding, only another one is taken that is as good, and none where
    // it is: with colours learned from what lies there a missing thumb looks as good as any.
    if (seen.gestures.watches() && (seen.gestures.folded() || !seen.gestures.fits(best))) continue;
    // Of two readings of one hand the picture decides, of two hands the one that is believed more.
    const bool better = reading == Reading::otherwise
                            ? best.log_ratio > followed_ratio
                            : candidate.log_odds + evidence_of(best, config.belief) > belief;
    if (!better) {
      seen.read_otherwise |= reading == Reading::otherwise && candidate.log_odds > 0;
      continue;
    }
    const bool stays = has_hand() && stays_at(fresh.best());
    seen.hypotheses = fresh;
    std::swap(aligner, scout);
    if (stays) return;  // the same hand in the same place, only laid anew
    seen.whole = true;
    seen.read_otherwise = false;
    seen.filter.reset();
    seen.own_layout = candidate.layout;
    if (seen.state == State::tracking) seen.changed_s = seen.time_s;
    if (reading == Reading::elsewhere) seen.belief = candidate.log_odds;
    return;
  }
}

bool HandTracker::Impl::stays_at(const Hypothesis& fresh) const noexcept {
  const HandVector moved = seen.hypotheses.best().alignment.state.difference(fresh.alignment.state);
  return place_of(fresh).same_tips(followed()) && moved.head<3>().norm() < config.belief.doubt_rad;
}

bool HandTracker::Impl::holds_hand() const noexcept {
  return has_hand() && seen.whole &&
         seen.hypotheses.best().alignment.log_ratio >= config.belief.seen;
}

void HandTracker::Impl::believe(double dt_s) noexcept {
  const BeliefConfig& limits = config.belief;
  if (has_hand()) {
    const double share = std::clamp(dt_s / limits.same_s, 0.0, 1.0);
    const double says =
        seen.whole ? evidence_of(seen.hypotheses.best().alignment, limits) : -limits.most_frame;
    seen.belief = std::min(seen.belief + share * says, limits.most);
  }
  const bool was = has_followed();
  if (!has_hand() || seen.belief < limits.give_up) {
    seen.hypotheses.clear();
    seen.belief = 0;
    constexpr double kRemember_s = 3.0;
    seen.state = was && seen.time_s - seen.tracked_s < kRemember_s ? State::lost : State::searching;
  } else if (seen.belief > limits.believe || seen.state == State::tracking) {
    seen.state = State::tracking;
    seen.tracked_s = seen.time_s;
  } else {
    seen.state = was ? State::lost : State::acquiring;
  }
  if (seen.gestures.holds()) {
    seen.state = State::lost;
    seen.tracked_s = seen.time_s;
  }
}

void HandTracker::Impl::filter(TrackResult& result) noexcept {
  const Alignment& best = in_view()->alignment;
  PoseEstimate raw;
  raw.T_camera_hand = best.state.T_camera_hand;
  raw.covariance = pose_information(best.information).llt().solve(Matrix6d::Identity());
  raw.noise_covariance = kNoisePart * raw.covariance;
  if (!seen.gestures.holds()) raw.covariance += seen.hypotheses.spread();
  if (hand.source == HandSource::average_adult)
    raw.covariance.bottomRightCorner<3, 3>() += origin_covariance(raw.T_camera_hand);
  raw.rms_px = best.rms_px;
  // A hand that turns over goes on in another hand frame: the half turn between them is no motion.
  const Layout layout = in_view()->appearance.layout;
  if (layout != seen.filtered_layout) seen.filter.reset();
  seen.filtered_layout = layout;
  seen.filter.update(seen.time_s, raw);
  const auto filtered = seen.filter.predict(seen.time_s);
  if (seen.gestures.holds()) {
    result.held_pose = filtered;
  } else {
    result.raw_pose = raw;
    result.pose = filtered;
  }
}

void HandTracker::Impl::learn(const ImageView& frame, double dt_s) noexcept {
  const Hypothesis& best = seen.hypotheses.best();
  if (!holds_hand()) return;
  constexpr double kMargin_m = 0.0011;  // blur: the boundary's own colours are neither side's
  const double keep = std::exp(-dt_s / config.learning.colors_s);
  aligner.learn(frame, camera, best.appearance, best.alignment.state, static_cast<float>(keep),
                kMargin_m);
  if (seen.state == State::tracking) {
    constexpr double kFirst_s = 1.0;
    const double stands_for_s = std::min(dt_s, kLongest_s);
    seen.learned_s += stands_for_s;
    const double views =
        stands_for_s / (config.learning.view_share * std::max(kFirst_s, seen.learned_s));
    aligner.learn_texture(frame, camera, best.appearance, best.alignment,
                          std::min(dt_s / config.learning.texture_s, 1.0), views);
    seen.hypotheses.learn_person(views, config);
    seen.person = best.person;
  }
  learned_hand = hand_of_figure(seen.person.estimate(), best.appearance.layout);
  learned_hand.source = hand.scale_assumed() ? HandSource::self : hand.source;
  learned_hand.average_scale = hand.scale_assumed();
  learned_hand.thickness_m = hand.thickness_m;
}

}  // namespace handyar
