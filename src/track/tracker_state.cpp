// SPDX-License-Identifier: MIT
#include "track/tracker_state.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "align/silhouette.hpp"

namespace handyar {
namespace {

// The hand frame's origin hangs on how a person holds middle finger and thumb at rest, which the
// figure does not tell: where the fingertips were never measured it lies so far from where the
// average hand has it (standard deviation in the hand plane).
constexpr double kOrigin_m = 0.0055;

/// What the origin of a hand that was never measured adds to the covariance of its translation.
Eigen::Matrix3d origin_covariance(const Eigen::Isometry3d& T_camera_hand) {
  const Eigen::Matrix<double, 3, 2> origin_m = kOrigin_m * T_camera_hand.linear().leftCols<2>();
  return origin_m * origin_m.transpose();
}

/// What the size of a hand that was never measured adds to it: people's differ as their figures do.
Eigen::Matrix3d size_covariance(const Eigen::Isometry3d& T_camera_hand) {
  const double share =
      relative_size_derivative().norm() / relative_size(FigureCoefficients::Zero());
  const Eigen::Vector3d off_m = share * T_camera_hand.translation();
  return off_m * off_m.transpose();
}

/// A picture tells a hand's shape, not its size: larger and farther away it looks the same. So the
/// pose is told as that of a hand of the average size, and its information likewise. The figure's
/// own would not do: within five seconds real hands that are held still shrink by a sixth, since
/// their shapes are those of smaller hands.
void to_average_size(const FigureCoefficients& figure, Eigen::Isometry3d& T_camera_hand,
                     HandMatrix& information) {
  const double size = relative_size(figure);
  T_camera_hand.translation() /= size;
  // The translation is `size` times the reported one.
  HandMatrix by_reported = HandMatrix::Identity();
  by_reported.block<3, 3>(3, 3) *= size;
  by_reported.block<3, kFigureModes>(3, kFigureAt) =
      T_camera_hand.translation() * relative_size_derivative().transpose();
  information = by_reported.transpose() * information * by_reported;
}

}  // namespace

HandTracker::Impl::Impl(const Camera& c, const HandModel& h, const Config& cfg)
    : config(cfg),
      hand(h),
      calibrated_camera(c),
      camera(c),
      seen{.hypotheses = {},
           .gestures = {},
           .person = Person(h),
           .filter = PoseFilter(config.filter)},
      learned_hand(h) {
  outline.reserve(Silhouette::kMaxAnchors);
}

void HandTracker::Impl::reset() noexcept {
  seen = {.hypotheses = {},
          .gestures = {},
          .person = Person(hand),
          .filter = PoseFilter(config.filter)};
  aligner.forget();
  scout.forget();
  finder.reset();
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
    seen.belief = seen.lately = 0;
  }
  return FrameStatus::ok;
}

void HandTracker::Impl::follow(const ImageView& frame, double dt_s) noexcept {
  const bool can_be_seen = seen.hypotheses.follow(frame, camera, dt_s, config, aligner);
  keep_outline();
  seen.hypotheses.reconsider(frame, camera, dt_s, config, aligner);
  if (!can_be_seen || follows_hand_of_other()) seen.hypotheses.clear();
  if (!has_hand()) return;
  seen.inside = look_inside(seen.hypotheses.best(), frame, aligner);
  tell_from_other();
}

void HandTracker::Impl::keep_outline() noexcept {
  const std::span<const OutlinePoint> its = aligner.outline();
  outline.assign(its.begin(), its.end());
}

void HandTracker::Impl::compare_postures(const ImageView& frame, double dt_s) noexcept {
  Gestures& gestures = seen.gestures;
  const bool open = has_hand() && (seen.state == State::tracking || gestures.holds());
  gestures.update(frame, camera, open ? &seen.hypotheses.best() : nullptr, dt_s, config, aligner);
  if (gestures.folded()) seen.hypotheses.clear();
  if (gestures.opened()) {
    seen.hypotheses.resume(gestures.hand());
    seen.inside = look_inside(gestures.hand(), frame, aligner);
    seen.belief = config.belief.believe + config.belief.most_frame();
  }
}

const Hypothesis* HandTracker::Impl::in_view() const noexcept {
  if (seen.gestures.holds()) return &seen.gestures.hand();
  return has_hand() ? &seen.hypotheses.best() : nullptr;
}

bool HandTracker::Impl::holds_hand() const noexcept {
  if (!has_hand()) return false;
  const Alignment& best = seen.hypotheses.best().alignment;
  return is_whole(best, seen.inside) && best.log_ratio >= config.belief.seen();
}

PartRatios HandTracker::Impl::look_inside(const Hypothesis& its, const ImageView& frame,
                                          const Aligner& by) const noexcept {
  return by.ratios_inside(frame, camera, its.appearance, its.alignment.state);
}

void HandTracker::Impl::believe(double dt_s) noexcept {
  const BeliefConfig& limits = config.belief;
  if (has_hand()) {
    const double share = std::clamp(dt_s / limits.same_s, 0.0, 1.0);
    const double says = limits.evidence_of(seen.hypotheses.best().alignment, seen.inside);
    seen.belief = std::min(seen.belief + share * says, limits.most());
    seen.lately += share * (says - seen.lately);
  }
  const bool was = has_followed();
  if (!has_hand() || seen.belief < limits.give_up()) {
    seen.hypotheses.clear();
    seen.belief = seen.lately = 0;
    const bool remembered = seen.time_s - seen.tracked_s < config.learning.remember_s;
    seen.state = was && remembered ? State::lost : State::searching;
  } else if (seen.belief > limits.believe || seen.state == State::tracking) {
    seen.state = State::tracking;
    seen.tracked_s = seen.time_s;
    if (holds_hand()) seen.place = followed();
  } else {
    seen.state = was ? State::lost : State::acquiring;
  }
  if (seen.gestures.holds()) {
    seen.state = State::lost;
    seen.tracked_s = seen.time_s;
  }
}

void HandTracker::Impl::filter(double dt_s, TrackResult& result) noexcept {
  const Alignment& best = in_view()->alignment;
  PoseEstimate raw;
  HandMatrix information = best.information;
  raw.T_camera_hand = best.state.T_camera_hand;
  if (hand.scale_assumed()) to_average_size(best.state.figure, raw.T_camera_hand, information);
  raw.covariance = pose_information(information).llt().solve(Matrix6d::Identity());
  // Most of its errors come from what the figure cannot explain and stay while the view does.
  raw.noise_covariance = std::min(dt_s, kLongest_s) / config.learning.remember_s * raw.covariance;
  if (!seen.gestures.holds()) raw.covariance += seen.hypotheses.spread(hand.scale_assumed());
  if (hand.source == HandSource::average_adult)
    raw.covariance.bottomRightCorner<3, 3>() += origin_covariance(raw.T_camera_hand);
  if (hand.scale_assumed())
    raw.covariance.bottomRightCorner<3, 3>() += size_covariance(raw.T_camera_hand);
  raw.rms_px = best.rms_px;
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
  const double keep = std::exp(-dt_s / config.belief.same_s);
  aligner.learn(frame, camera, best.appearance, best.alignment.state, static_cast<float>(keep),
                kNearSteps.finest);
  if (seen.state == State::tracking) {
    const double stands_for_s = std::min(dt_s, kLongest_s);
    seen.learned_s += stands_for_s;
    // Views come back, and the figure's errors with them: of all the time the same share counts.
    const double views =
        stands_for_s /
        (config.belief.same_s * std::max(1.0, seen.learned_s / config.learning.remember_s));
    aligner.learn_texture(frame, camera, best.appearance, best.alignment,
                          std::min(dt_s / config.learning.remember_s, 1.0), views);
    seen.hypotheses.learn_person(views, config);
    seen.person = best.person;
  }
  learned_hand =
      hand_of_figure(seen.person.estimate(), best.appearance.layout, hand.scale_assumed());
  learned_hand.source = hand.scale_assumed() ? HandSource::self : hand.source;
  learned_hand.thickness_m = hand.thickness_m;
}

}  // namespace handyar
