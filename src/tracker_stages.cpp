// SPDX-License-Identifier: MIT
// The stages of the paper's Figure 2 around a hand that is followed, or was just found.
#include <algorithm>
#include <cmath>

#include "handyar/hand_outline.hpp"
#include "handyar/matching.hpp"
#include "tracker_impl.hpp"

namespace handyar {

PixelRect HandTracker::Impl::region_of_interest(double dt_s) const noexcept {
  const Eigen::Vector2f shift = static_cast<float>(dt_s) * velocity_px_s;
  const float margin = shape.palm_radius() + 0.5f * shift.norm();
  const Eigen::AlignedBox2f box = shape.bounds();
  const Eigen::Vector2f limit(static_cast<float>(width_px), static_cast<float>(height_px));
  const Eigen::Vector2f low =
      (box.min() + shift - Eigen::Vector2f::Constant(margin)).cwiseMax(0.0f).cwiseMin(limit);
  const Eigen::Vector2f high =
      (box.max() + shift + Eigen::Vector2f::Constant(margin)).cwiseMax(low).cwiseMin(limit);
  return {static_cast<int>(low.x()), static_cast<int>(low.y()),
          static_cast<int>(std::ceil(high.x())) - static_cast<int>(low.x()),
          static_cast<int>(std::ceil(high.y())) - static_cast<int>(low.y())};
}

/// Leaves bins: a part of the frame at 1/step of its size. Where their chroma is noisier than
/// `noise` it is averaged over `radius` bins around, and the answer is true.
bool HandTracker::Impl::read(const ImageView& frame, const PixelRect& part, int step, double noise,
                             int radius) noexcept {
  read_bins(frame, part, step, bins);
  const bool averaged = chroma_noise(bins) > noise;
  if (averaged) chroma.smooth(radius, bins);
  return averaged;
}

/// The neighbourhood of where the hand is expected: leaves bins, and the last shape in them as it
/// was and as it is expected to be now; `anew`, `shape` is of this frame.
bool HandTracker::Impl::read_neighbourhood(const ImageView& frame, bool anew) noexcept {
  const double dt = anew ? 0.0 : std::min(time_s - seen_s, 0.1);
  const int step = tracking_step();
  const double finger_bins = shape.finger_width / static_cast<float>(step);
  noisy = read(frame, region_of_interest(dt), step,
               config.noise.tracked * (noisy ? config.noise.lasting : 1),
               std::max(1, static_cast<int>(config.noise.width_share * finger_bins)));
  before = to_mask(shape);
  expected = before.transformed(
      1, static_cast<float>(dt) / static_cast<float>(bins.step_px) * velocity_px_s);
  return bins.width >= 16 && bins.height >= 16;
}

/// Segmentation (paper 2.1) by colour, or `where_expected` by colour, place and edges: leaves mask,
/// component and contour.
bool HandTracker::Impl::segment(bool where_expected) noexcept {
  if (where_expected) expected.expect(bins.width, bins.height, expectation);
  const Component* hand = stages.region.segment(
      bins, skin.ratios(), where_expected ? expectation : anywhere, expected.parts(), least_area());
  colorless = false;
  return trace(hand);
}

/// Where colours do not show the hand, its own outline may lie among the edges: leaves what
/// segment() leaves, the hand's silhouette for a mask.
bool HandTracker::Impl::follow_outline() noexcept {
  if (!may_go_by_outline() || own_shape.layout() != shape.layout) return false;
  HandShape hand = own_shape.laid_on(expected);
  if (search.outlines().follow(bins, hand) < config.acquisition.least_support) return false;
  before = expected = hand;
  silhouette.resize(bins.width, bins.height);
  draw_silhouette(hand, silhouette);
  colorless = true;
  return trace(silhouette);
}

bool HandTracker::Impl::trace(const Component* hand) noexcept {
  if (hand == nullptr) return false;
  component = *hand;
  return stages.contour.trace(stages.region.mask(), component);
}

/// A mask that was made elsewhere: what it holds where the hand is expected.
bool HandTracker::Impl::trace(const Mask& mask) noexcept {
  stages.region.classify(mask);
  stages.region.components(least_area());
  return trace(stages.region.component_at(int(expected.palm().x()), int(expected.palm().y())));
}

/// Places where the contour turns as sharply as a fingertip (paper 2.2).
bool HandTracker::Impl::find_fingertips() noexcept {
  stages.curvature.find(stages.contour, before.palm_radius());
  return static_cast<int>(stages.curvature.tips().size()) >= config.matching.min_tips;
}

/// Which is which finger, after the frame before (paper 2.3) or, `anew`, after the search in this
/// one; true when tips and valleys together are a hand's. Leaves `found`.
bool HandTracker::Impl::match(bool anew) noexcept {
  promising = false;
  int matched = assign_tips(anew);
  if (matched < (anew ? kFingerCount : config.matching.min_tips) || !find_valleys()) return false;
  tip_inferred.fill(false);
  tip_doubt_px.fill(0);
  if (!anew) matched -= judge_tips();
  if (contradicts_model()) return false;
  const HandShapeConfig limits = limits_of_belief();
  const bool accepted = shape_model.fit(limits, found);
  promising = found.deviation < config.search.max_deviation;
  if (!accepted || (matched == kFingerCount && has_turned_over(limits))) return false;
  place_what_was_missed();
  if (!fills_region(found, stages.region.mask(), limits)) return false;
  if (matched == kFingerCount) five_tips_s = time_s;
  return time_s - five_tips_s <= config.acquisition.max_missing_tip_s;
}

/// The tips of `found` after those of `before`; how many are matched.
int HandTracker::Impl::assign_tips(bool anew) noexcept {
  const auto tips = stages.curvature.tips();
  std::array<Eigen::Vector2f, CurvatureFinder::kMaxTips> candidates;
  for (std::size_t i = 0; i < tips.size(); ++i) candidates[i] = tips[i].at - component.centroid;

  const Eigen::Vector2f centroid_before =
      anew ? component.centroid
           : Eigen::Vector2f((centroid_px - bins.origin_px()) / static_cast<float>(bins.step_px));
  std::array<Eigen::Vector2f, kFingerCount> previous;
  for (int f = 0; f < kFingerCount; ++f) previous[f] = before.tips[f] - centroid_before;
  constexpr float kSpan = 4.5f;  // from thumb to little finger, in palm radii
  const float gate =
      static_cast<float>(config.matching.max_displacement) * kSpan * before.palm_radius();
  const TipAssignment assignment =
      match_tips(previous, {candidates.data(), tips.size()}, before.layout, gate);

  found = before;
  int matched = 0;
  for (int f = 0; f < kFingerCount; ++f) {
    found.tip_seen[f] = assignment[f] >= 0;
    if (!found.tip_seen[f]) continue;
    found.tips[f] = tips[assignment[f]].at;
    found.tip_samples[f] = tips[assignment[f]].sample;
    ++matched;
  }
  return matched;
}

/// The valleys of `found` between its tips. False when two fingers have none between them.
bool HandTracker::Impl::find_valleys() noexcept {
  const bool forward = found.layout == Layout::thumb_left;  // clockwise from finger k to k + 1
  for (int k = 0; k < kValleyCount; ++k) {
    found.valley_seen[k] = found.tip_seen[k] && found.tip_seen[k + 1];
    if (!found.valley_seen[k]) continue;
    float depth = 0;
    const int at = stages.curvature.valley(found.tip_samples[forward ? k : k + 1],
                                           found.tip_samples[forward ? k + 1 : k], &depth);
    if (depth < config.matching.min_valley_depth * before.palm_radius()) return false;
    found.valleys[k] = stages.curvature.samples()[at];
  }
  return true;
}

/// A finger that is suddenly longer or shorter runs on into what has the hand's colour, or is cut
/// by a shadow, and sometimes a second one with it. Far off, a tip was misread; less so, it tells
/// less of the pose, unless it was drawn from the hand's own shape. Returns how many were misread.
int HandTracker::Impl::judge_tips() noexcept {
  constexpr float kAgree_m = 0.005f;
  constexpr int kMostDoubted = 2;
  int misread = 0;
  HandShape others = found;
  for (int i = 0; i < kMostDoubted; ++i) {
    const OwnShape::OddTip odd = own_shape.odd_tip(others, kAgree_m);
    if (!(odd.off_m > 0)) break;
    others.tip_seen[odd.finger] = false;
    if (odd.off_m > config.shape.misread_m) {
      found.tip_seen[odd.finger] = false;
      ++misread;
    } else if (!colorless) {
      tip_doubt_px[odd.finger] = odd.off_m * odd.px_per_m;
    }
  }
  for (int f = 0; f < kFingerCount; ++f)
    tip_inferred[f] = !found.tip_seen[f] && own_shape.infer_tip(f, found);
  return misread;
}

/// What counts as a hand here and now: with hysteresis once it is tracked.
HandShapeConfig HandTracker::Impl::limits_of_belief() const noexcept {
  HandShapeConfig limits = config.shape;
  if (state == State::tracking || state == State::lost) {
    limits.max_deviation *= config.shape.tracked_deviation;
    limits.min_aspect *= config.shape.tracked_aspect;
  } else {
    limits.max_deviation *= following ? config.shape.acquired_deviation : search.tolerance();
  }
  // Until its own shape is known, a hand that suddenly is less like one has grown together with
  // what it touches.
  if (!own_shape.is_known())
    limits.max_deviation = std::min(limits.max_deviation, before.deviation + config.shape.max_leap);
  return limits;
}

/// No finger is much longer or shorter than the hand model has it: one that runs on into what has
/// its colour can pass for a hand that is seen aslant, until it is compared with the others.
bool HandTracker::Impl::contradicts_model() const noexcept {
  constexpr float kAgree_m = 0.012f;  // what perspective and posture leave
  const bool average = hands[0].source == HandSource::average_adult;
  return modelled_shape.odd_tip(found, kAgree_m).off_m >
         (average ? config.shape.average_odd_tip_m : config.shape.odd_tip_m);
}

/// A hand that has turned over meanwhile can pass for a distorted one of the old layout.
bool HandTracker::Impl::has_turned_over(const HandShapeConfig& limits) const noexcept {
  HandShape turned = found;
  turned.layout = opposite(found.layout);
  std::ranges::reverse(turned.tips);
  std::ranges::reverse(turned.valleys);
  return shape_model.fit(limits, turned) &&
         turned.deviation < config.shape.turned_over_share * found.deviation;
}

/// A tip or valley that was missed stays where the shape puts it, for the next frame's matching.
void HandTracker::Impl::place_what_was_missed() noexcept {
  const Eigen::Vector2f moved = found.palm() - before.palm();
  for (int f = 0; f < kFingerCount; ++f)
    if (!found.tip_seen[f] && !tip_inferred[f]) found.tips[f] = before.tips[f] + moved;
  for (int k = 0; k < kValleyCount; ++k)
    if (!found.valley_seen[k]) found.valleys[k] = before.valleys[k] + moved;
}

/// Where each fingertip is, to a fraction of a pixel (paper 2.2).
void HandTracker::Impl::measure_tips(TrackResult& result) noexcept {
  result.tips = {};
  result.valleys = {};
  for (int f = 0; f < kFingerCount; ++f) {
    if (tip_inferred[f]) result.tips[f] = {to_input(found.tips[f]).cast<double>(), false, true};
    if (!found.tip_seen[f]) continue;
    const float arc = static_cast<float>(found.tip_samples[f]) * stages.curvature.spacing();
    const Eigen::Vector2f tip = measure_tip(stages.contour, arc, found.finger_base(f),
                                            found.finger_width, config.fingertips.method);
    result.tips[f] = {to_input(tip).cast<double>(), true, false};
  }
  for (int k = 0; k < kValleyCount; ++k) {
    if (!found.valley_seen[k]) continue;
    const Eigen::Vector2f valley = measure_valley(stages.contour, found.valleys[k], found.tips[k],
                                                  found.tips[k + 1], found.finger_width);
    result.valleys[k] = {to_input(valley).cast<double>(), true, false};
  }
}

/// Where the middle of each finger runs.
void HandTracker::Impl::measure_axes(TrackResult& result) noexcept {
  result.axes = {};
  for (int f = 0; f < kFingerCount; ++f) {
    const int first = std::max(f - 1, 0), last = std::min(f, kValleyCount - 1);
    if (!found.tip_seen[f] || !found.valley_seen[first] || !found.valley_seen[last]) continue;
    const float arc = static_cast<float>(found.tip_samples[f]) * stages.curvature.spacing();
    MeasuredAxis axis;
    if (measure_axis(stages.contour, arc, found.finger_base(f),
                     {found.valleys.data() + first, std::size_t(last - first + 1)},
                     found.finger_width, axis))
      result.axes[f] = {to_input(axis.end).cast<double>(), to_input(axis.root).cast<double>(),
                        true};
  }
}

/// Camera pose relative to the hand (paper 2.5). False when a measured hand cannot look like this.
bool HandTracker::Impl::estimate_pose(TrackResult& result) noexcept {
  HandObservation observation;
  const FingertipConfig& measured = config.fingertips;
  const double tip_noise = measured.method == FingertipMethod::curvature ? measured.curvature_noise
                                                                         : measured.ellipse_noise;
  const double finger_px =
      bins.step_px * std::max(found.finger_width, 10.0f) * (colorless ? measured.outline_noise : 1);
  for (int f = 0; f < kFingerCount; ++f)
    observation.tips[f] = {result.tips[f].px,
                           std::hypot(tip_noise * finger_px, bins.step_px * tip_doubt_px[f]),
                           result.tips[f].seen};
  for (int k = 0; k < kValleyCount; ++k)
    observation.valleys[k] = {result.valleys[k].px, measured.valley_noise * finger_px,
                              result.valleys[k].seen};
  for (int f = 0; f < kFingerCount; ++f)
    observation.axes[f] = {result.axes[f].end_px, result.axes[f].root_px,
                           measured.axis_noise * finger_px, result.axes[f].seen};
  PosePrior prior;
  if (const auto predicted = filter.predict(time_s))
    prior.prediction = PosePrediction{predicted->T_camera_hand, predicted->covariance};
  // Palm and back have heights of opposite sign. With valleys the frames tell which is seen, little
  // by little; tips alone do not, and the model's face is the likelier one.
  const HandModel& model = hand(found.layout);
  prior.relief_probability = model.has_valleys ? 1 / (1 + std::exp(-relief_evidence))
                             : found.layout == measured_layout ? 1.0
                                                               : 0.5;
  result.raw_pose = handyar::estimate_pose(observation, model, camera, config.pose, prior);
  if (model.source != HandSource::average_adult) {
    if (!result.raw_pose) return false;
    const double m_per_px = result.raw_pose->T_camera_hand.translation().z() / camera.fx_px;
    if (result.raw_pose->rms_px * m_per_px >
        (following ? config.acquisition.max_residual_m : config.acquisition.new_residual_m))
      return false;
  }
  return true;
}

void HandTracker::Impl::filter_pose(TrackResult& result) noexcept {
  // Errors of neighbouring frames are alike: each counts by the time it stands for.
  constexpr double kPer_s = 6.0, kLongest_s = 0.05;
  const double share = kPer_s * std::min(time_s - filtered_s, kLongest_s);
  filtered_s = time_s;
  if (result.raw_pose && std::isfinite(result.raw_pose->relief_log_ratio)) {
    constexpr double kLimit = 6.0;
    relief_evidence =
        std::clamp(relief_evidence + share * result.raw_pose->relief_log_ratio, -kLimit, kLimit);
  }
  if (result.raw_pose && std::isfinite(result.raw_pose->planar_log_ratio)) {
    // Where frame after frame says that the other planar solution is it, the filter holds on to the
    // wrong one: it begins anew.
    constexpr double kEnough = 2.0;
    planar_evidence =
        std::min(0.0, (1 - share) * planar_evidence + share * result.raw_pose->planar_log_ratio);
    if (planar_evidence < -kEnough) {
      planar_evidence = 0;
      filter.reset();
      if (!estimate_pose(result)) return;
    }
  }
  if (result.raw_pose) filter.update(time_s, *result.raw_pose);
  result.pose = filter.predict(time_s);
}

/// Colours of the verified hand and of what surrounds it go back into the skin model (paper 2.1).
void HandTracker::Impl::learn(const BinView& image, const Mask& mask,
                              const HandShape& hand_shape) noexcept {
  if (!std::ranges::all_of(hand_shape.valley_seen, [](bool seen) { return seen; })) return;
  sample_skin(image, &mask, hand_shape, samples);
  skin.learn(samples.hand, samples.background);
}

}  // namespace handyar
