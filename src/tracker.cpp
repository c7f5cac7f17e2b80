// SPDX-License-Identifier: MIT
#include "handyar/tracker.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "handyar/hand_outline.hpp"
#include "handyar/hand_search.hpp"
#include "handyar/matching.hpp"
#include "handyar/skin_model.hpp"
#include "skin_samples.hpp"
#include "stage_clock.hpp"

namespace handyar {

std::string_view name(State state) noexcept {
  switch (state) {
    case State::searching:
      return "searching";
    case State::acquiring:
      return "acquiring";
    case State::tracking:
      return "tracking";
    case State::lost:
      return "lost";
  }
  return "unknown";
}

struct HandTracker::Impl {
  Impl(const Camera& c, const HandModel& hand, const Config& cfg)
      : config(cfg),
        calibrated_camera(c),
        camera(c),
        measured_layout(hand.layout),
        hands{hand.for_layout(Layout::thumb_right), hand.for_layout(Layout::thumb_left)},
        skin(cfg.skin),
        shape_model(hand, cfg.shape),
        search(cfg.search, cfg.fingertips, cfg.shape, shape_model),
        curvature(cfg.fingertips),
        filter(cfg.filter) {}

  void prepare(const ImageView& frame);
  void forget() noexcept;

  // The stages, in the order of the paper's Figure 2.
  bool find_anywhere(const ImageView& frame) noexcept;
  bool find_own_outline() noexcept;
  void go_to(const HandShape& candidate) noexcept;
  void forget_found() noexcept;
  bool read_neighbourhood(const ImageView& frame) noexcept;
  bool segment(bool where_expected) noexcept;
  bool adopt_found(const ImageView& frame) noexcept;
  bool follow_outline() noexcept;
  bool trace(const Component* hand) noexcept;
  bool find_fingertips() noexcept;
  bool match(bool anew) noexcept;
  void advance(bool seen) noexcept;
  void measure_tips(TrackResult& result) noexcept;
  bool estimate_pose(TrackResult& result) noexcept;
  void filter_pose(TrackResult& result) noexcept;
  void learn(const BinImage& image, const Mask& mask, const HandShape& hand_shape) noexcept;

  bool may_go_by_outline() const noexcept {
    return own_shape.is_known() && time_s - colored_s < config.acquisition.max_colorless_s;
  }
  int search_step() const noexcept {
    const int longer = std::max(width_px, height_px);
    return std::max(2, (longer + config.search.longer_side / 2) / config.search.longer_side);
  }
  PixelRect region_of_interest(double dt_s) const noexcept;
  Eigen::Vector2f to_input(const Eigen::Vector2f& p) const noexcept {
    return {static_cast<float>(bins.x_px(p.x())), static_cast<float>(bins.y_px(p.y()))};
  }
  HandShape to_input(const HandShape& s) const noexcept {
    return s.transformed(static_cast<float>(bins.step_px), bins.origin_px());
  }
  HandShape to_mask(const HandShape& shape_px) const noexcept {
    const float scale = 1.0f / static_cast<float>(bins.step_px);
    return shape_px.transformed(scale, -scale * bins.origin_px());
  }
  int least_area() const noexcept { return bins.width * bins.height / 50; }
  const HandModel& hand(Layout layout) const noexcept { return hands[static_cast<int>(layout)]; }

  Config config;
  Camera calibrated_camera, camera;  // as given; at the size of the frames
  Layout measured_layout;
  HandModel hands[2];  // one per layout
  int width_px = 0, height_px = 0;

  SkinModel skin;
  SkinModel::Learned trusted_skin;  // as it was when the hand was last tracked
  HandShapeModel shape_model;
  HandSearch search;
  BinImage bins;  // of the neighbourhood, or of the whole frame while searching it
  ExpectedRegion expectation;
  const ExpectedRegion anywhere{.ratios = {ExpectedRegion::kInside}};
  RegionFinder region;
  Contour contour;
  CurvatureFinder curvature;
  PoseFilter filter;
  SkinSamples samples;
  Mask silhouette;
  std::vector<Eigen::Vector2f> contour_px;
  int contour_size = 0;

  // What is known of the hand from frame to frame.
  State state = State::searching;
  bool following = false;      // `shape` tells where the hand was in the last frame
  HandShape shape;             // input pixels
  bool promising = false;      // `found` was refused, but not by much
  HandShape before, expected;  // mask pixels of this frame: `shape`, and where it should be now
  HandShape found;             // mask pixels of this frame
  std::array<bool, kFingerCount> tip_inferred{};  // of `found`: from own_shape
  OwnShape own_shape;
  Component component;
  Eigen::Vector2f centroid_px = Eigen::Vector2f::Zero();
  Eigen::Vector2f velocity_px_s = Eigen::Vector2f::Zero();
  double time_s = -std::numeric_limits<double>::infinity();
  double seen_s = 0;        // when the hand was last seen
  double first_seen_s = 0;  // since when it is seen without a break
  double tracked_s = -std::numeric_limits<double>::infinity();  // when it was last tracked
  double five_tips_s = 0;                                       // when all five tips were last seen
  int seen_frames = 0;
  bool colorless = false;        // the outline alone shows the hand in this frame
  double colored_s = 0;          // when it was last seen by its colours
  double relief_evidence = 0;    // log odds that heights are the model's, not mirrored
  float acquired_deviation = 1;  // of the search's best view of the hand that is being acquired
  struct {
    HandShape shape;
    bool following = false;
  } before_search;  // what was known, until what the search found is a hand at a closer look
};

void HandTracker::Impl::forget() noexcept {
  skin.reset();
  skin.keep(trusted_skin);
  search.reset();
  filter.reset();
  time_s = -std::numeric_limits<double>::infinity();
  state = State::searching;
  following = false;
  own_shape.reset();
  contour_size = 0;
  seen_frames = 0;
  relief_evidence = 0;
  tracked_s = -std::numeric_limits<double>::infinity();
}

void HandTracker::Impl::prepare(const ImageView& frame) {
  if (frame.width_px == width_px && frame.height_px == height_px) return;
  width_px = frame.width_px;
  height_px = frame.height_px;
  camera = calibrated_camera.scaled_to(width_px, height_px);
  const int pixels = width_px * height_px;
  bins.bins.resize(pixels);
  region.reserve(pixels, std::max(width_px, height_px));
  expectation.ratios.resize((width_px / 2 + 1) * (height_px / 2 + 1));  // cells of 2 or more
  const int step = search_step();
  search.reserve((width_px / step) * (height_px / step), std::max(width_px, height_px) / step);
  silhouette.reserve(pixels, std::max(width_px, height_px));
  contour.reserve(1 << 14);
  contour_px.resize(1 << 14);
  forget();
}

/// The whole frame at reduced size, by shape (paper 2.2). True when `shape` is new: a hand, or one
/// more like a hand than the one that is being acquired.
bool HandTracker::Impl::find_anywhere(const ImageView& frame) noexcept {
  read_bins(frame, {0, 0, width_px, height_px}, search_step(), bins);
  HandShape coarse;
  if (!search.find(bins, skin, coarse)) return false;
  const BinImage& seen = search.image();
  const HandShape candidate =
      coarse.transformed(static_cast<float>(seen.step_px), seen.origin_px());
  if (following && state == State::acquiring) {
    if (candidate.resembles(shape)) {
      acquired_deviation = std::min(acquired_deviation, candidate.deviation);
      return false;
    }
    if (candidate.deviation > 0.9f * acquired_deviation) return false;
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
/// of the hand that was lost.
bool HandTracker::Impl::find_own_outline() noexcept {
  if (!may_go_by_outline()) return false;
  for (const HandShape& proposal : search.outlines().proposals()) {
    if (proposal.layout != own_shape.layout()) continue;
    HandShape hand = own_shape.laid_on(proposal);
    if (search.outlines().follow(bins, hand) < config.acquisition.sure_support) continue;
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

/// The neighbourhood of where the hand is expected: leaves bins, and the last shape in them as it
/// was and as it is expected to be now.
bool HandTracker::Impl::read_neighbourhood(const ImageView& frame) noexcept {
  const double dt = state == State::searching ? 0.0 : std::min(time_s - seen_s, 0.1);
  const int enough_px = 900;  // along the longer side: finer than that costs and gains little
  const int step = std::max(1, std::max(width_px, height_px) / enough_px);
  read_bins(frame, region_of_interest(dt), config.half_resolution ? 2 * step : step, bins);
  before = to_mask(shape);
  expected = before.transformed(
      1, static_cast<float>(dt) / static_cast<float>(bins.step_px) * velocity_px_s);
  return bins.width >= 16 && bins.height >= 16;
}

/// Segmentation (paper 2.1) by colour, or `where_expected` by colour, place and edges: leaves mask,
/// component and contour.
bool HandTracker::Impl::segment(bool where_expected) noexcept {
  if (where_expected) expected.expect(bins.width, bins.height, expectation);
  const Component* hand =
      region.segment(bins, skin.ratios(), where_expected ? expectation : anywhere, expected.palm(),
                     expected.finger_width, least_area());
  return trace(hand);
}

/// What the search found, as it saw it: leaves what segment() leaves.
bool HandTracker::Impl::adopt_found(const ImageView& frame) noexcept {
  const BinImage& seen = search.image();
  const int step = seen.step_px;
  read_bins(frame, {seen.x0_px, seen.y0_px, seen.width * step, seen.height * step}, step, bins);
  before = expected = to_mask(shape);
  region.classify(search.mask());
  region.components(least_area());
  return trace(region.component_at(int(before.palm().x()), int(before.palm().y())));
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
  region.classify(silhouette);
  region.components(least_area());
  return trace(region.component_at(int(hand.palm().x()), int(hand.palm().y())));
}

bool HandTracker::Impl::trace(const Component* hand) noexcept {
  if (hand == nullptr) return false;
  component = *hand;
  return contour.trace(region.mask(), component);
}

/// Places where the contour turns as sharply as a fingertip (paper 2.2).
bool HandTracker::Impl::find_fingertips() noexcept {
  curvature.find(contour, before.palm_radius());
  return static_cast<int>(curvature.tips().size()) >= config.matching.min_tips;
}

/// Which is which finger, after the frame before (paper 2.3) or, `anew`, after the search in this
/// one; true when tips and valleys together are a hand's. Leaves `found`.
bool HandTracker::Impl::match(bool anew) noexcept {
  promising = false;
  const auto tips = curvature.tips();
  std::array<Eigen::Vector2f, CurvatureFinder::kMaxTips> candidates;
  for (std::size_t i = 0; i < tips.size(); ++i) candidates[i] = tips[i].at - component.centroid;

  const Eigen::Vector2f centroid_before =
      anew ? component.centroid
           : Eigen::Vector2f((centroid_px - bins.origin_px()) / static_cast<float>(bins.step_px));
  std::array<Eigen::Vector2f, kFingerCount> previous;
  for (int f = 0; f < kFingerCount; ++f) previous[f] = before.tips[f] - centroid_before;
  const float gate =
      static_cast<float>(config.matching.max_displacement) * 4.5f * before.palm_radius();
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
  if (matched < (anew ? kFingerCount : config.matching.min_tips)) return false;
  for (int k = 0; k < kValleyCount; ++k) {
    found.valley_seen[k] = found.tip_seen[k] && found.tip_seen[k + 1];
    if (!found.valley_seen[k]) continue;
    const bool forward = found.layout == Layout::thumb_left;  // clockwise from finger k to k + 1
    float depth = 0;
    const int at = curvature.valley(found.tip_samples[forward ? k : k + 1],
                                    found.tip_samples[forward ? k + 1 : k], &depth);
    if (depth < 0.25f * before.palm_radius()) return false;
    found.valleys[k] = curvature.samples()[at];
  }
  // A finger that is suddenly much longer or shorter runs on into what has the hand's colour.
  tip_inferred.fill(false);
  if (!anew) {
    const int misread = own_shape.misread(found);
    if (misread >= 0) {
      found.tip_seen[misread] = false;
      --matched;
    }
    for (int f = 0; f < kFingerCount; ++f)
      tip_inferred[f] = !found.tip_seen[f] && own_shape.infer_tip(f, found);
  }
  HandShapeConfig limits = config.shape;
  if (state == State::tracking || state == State::lost) {
    limits.max_deviation *= 1.6;  // hysteresis
    limits.min_aspect *= 0.6;
  } else if (following) {
    limits.max_deviation *= 1.2;
  }
  const bool accepted = shape_model.fit(limits, found);
  promising = found.deviation < config.search.max_deviation;
  if (!accepted) return false;
  // A hand that has turned over meanwhile can pass for a distorted one of the old layout.
  if (matched == kFingerCount) {
    HandShape turned = found;
    turned.layout = opposite(found.layout);
    std::ranges::reverse(turned.tips);
    std::ranges::reverse(turned.valleys);
    if (shape_model.fit(limits, turned) && turned.deviation < 0.7f * found.deviation) return false;
  }
  // A tip that was missed stays where the shape puts it, for the next frame's matching.
  const Eigen::Vector2f moved = found.palm() - before.palm();
  for (int f = 0; f < kFingerCount; ++f)
    if (!found.tip_seen[f] && !tip_inferred[f]) found.tips[f] = before.tips[f] + moved;
  for (int k = 0; k < kValleyCount; ++k)
    if (!found.valley_seen[k]) found.valleys[k] = before.valleys[k] + moved;
  if (!fills_region(found, region.mask(), limits)) return false;
  if (matched == kFingerCount) five_tips_s = time_s;
  return time_s - five_tips_s <= config.acquisition.max_missing_tip_s;
}

/// Where each fingertip is, to a fraction of a pixel (paper 2.2).
void HandTracker::Impl::measure_tips(TrackResult& result) noexcept {
  result.tips = {};
  result.valleys = {};
  for (int f = 0; f < kFingerCount; ++f) {
    if (tip_inferred[f]) result.tips[f] = {to_input(found.tips[f]).cast<double>(), false, true};
    if (!found.tip_seen[f]) continue;
    const float arc = static_cast<float>(found.tip_samples[f]) * curvature.spacing();
    const Eigen::Vector2f tip =
        measure_tip(contour, arc, found.finger_width, config.fingertips.method);
    result.tips[f] = {to_input(tip).cast<double>(), true, false};
  }
  for (int k = 0; k < kValleyCount; ++k) {
    if (!found.valley_seen[k]) continue;
    const Eigen::Vector2f valley = measure_valley(contour, found.valleys[k], found.tips[k],
                                                  found.tips[k + 1], found.finger_width);
    result.valleys[k] = {to_input(valley).cast<double>(), true, false};
  }
}

/// Camera pose relative to the hand (paper 2.5). False when a measured hand cannot look like this.
bool HandTracker::Impl::estimate_pose(TrackResult& result) noexcept {
  HandObservation observation;
  // By which share of a finger's width tips and valleys move from frame to frame when nothing does.
  constexpr double kTipNoise = 0.018, kValleyNoise = 0.025;
  constexpr double kColorless = 3;  // times as far where an outline tells, which is rougher
  const double finger_px =
      bins.step_px * std::max(found.finger_width, 10.0f) * (colorless ? kColorless : 1);
  for (int f = 0; f < kFingerCount; ++f)
    observation.tips[f] = {result.tips[f].px, kTipNoise * finger_px, result.tips[f].seen};
  for (int k = 0; k < kValleyCount; ++k)
    observation.valleys[k] = {result.valleys[k].px, kValleyNoise * finger_px,
                              result.valleys[k].seen};
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
    if (result.raw_pose->rms_px * m_per_px > config.acquisition.max_residual_m) return false;
  }
  return true;
}

void HandTracker::Impl::filter_pose(TrackResult& result) noexcept {
  if (result.raw_pose && std::isfinite(result.raw_pose->relief_log_ratio)) {
    // Errors of neighbouring frames are alike: each counts for a fraction.
    constexpr double kShare = 0.2, kLimit = 6.0;
    relief_evidence =
        std::clamp(relief_evidence + kShare * result.raw_pose->relief_log_ratio, -kLimit, kLimit);
  }
  if (result.raw_pose) filter.update(time_s, *result.raw_pose);
  result.pose = filter.predict(time_s);
}

/// Colours of the verified hand and of what surrounds it go back into the skin model (paper 2.1).
void HandTracker::Impl::learn(const BinImage& image, const Mask& mask,
                              const HandShape& hand_shape) noexcept {
  if (!std::ranges::all_of(hand_shape.valley_seen, [](bool seen) { return seen; })) return;
  sample_skin(image, &mask, hand_shape, samples);
  skin.learn(samples.hand, samples.background);
}

/// The states: when a hand is believed, and when it is given up.
void HandTracker::Impl::advance(bool seen) noexcept {
  const AcquisitionConfig& limits = config.acquisition;
  const bool known = time_s - tracked_s < limits.remember_s;
  if (seen) {
    const HandShape now = to_input(found);
    const bool resumed = following && state == State::lost;
    if (following) {
      velocity_px_s = (now.palm() - shape.palm()) / static_cast<float>(time_s - seen_s);
    } else {
      if (!known || own_shape.layout() != found.layout) own_shape.reset();
      first_seen_s = time_s;
      seen_frames = 0;
      filter.reset();
    }
    ++seen_frames;
    const bool confirmed =
        time_s - first_seen_s > (known ? limits.reconfirm_s : limits.confirm_s) - 1e-6 &&
        seen_frames >= (known ? 2 : limits.confirm_frames);
    if (state != State::tracking) state = resumed || confirmed ? State::tracking : State::acquiring;
    if (!colorless) colored_s = time_s;
    if (state == State::tracking) {
      // The hand's own shape, from frames that are likely right, over about this long.
      constexpr double kMemory_s = 0.7, kLikely = 0.75;
      const auto all = [](const auto& flags) {
        return std::ranges::all_of(flags, std::identity());
      };
      if (!colorless && found.deviation < kLikely * config.shape.max_deviation &&
          all(found.tip_seen) && all(found.valley_seen))
        own_shape.learn(found, static_cast<float>((time_s - seen_s) / kMemory_s));
      tracked_s = time_s;
    }
    shape = now;
    centroid_px = to_input(component.centroid);
    following = true;
    seen_s = time_s;
    return;
  }
  if (state == State::tracking) skin.keep(trusted_skin);
  state = known ? State::lost : State::searching;
  following = following && time_s - tracked_s < limits.coast_s;
  if (!following) {
    skin.restore(trusted_skin);
    filter.reset();
  }
}

HandTracker::HandTracker(const Camera& camera, const HandModel& hand, const Config& config)
    : impl_(std::make_unique<Impl>(camera, hand, config)) {}
HandTracker::~HandTracker() = default;
HandTracker::HandTracker(HandTracker&&) noexcept = default;
HandTracker& HandTracker::operator=(HandTracker&&) noexcept = default;

TrackResult HandTracker::process(const ImageView& frame, double time_s) noexcept {
  Impl& t = *impl_;
  TrackResult result;
  result.time_s = time_s;
  result.status = check(frame);
  if (result.status == FrameStatus::ok && !(std::isfinite(time_s) && time_s > t.time_s))
    result.status = FrameStatus::time_not_increasing;
  result.state = t.state;
  result.scale_assumed = t.hands[0].scale_assumed();
  result.camera_assumed = t.calibrated_camera.assumed;
  if (result.status != FrameStatus::ok) return result;
  t.prepare(frame);
  t.time_s = time_s;

  const StageClock clock(t.config.now_s);
  StageTimes& times = result.times;
  const auto identify = [&](bool anew) {
    return clock.time(times.fingertips_ms, [&] { return t.find_fingertips(); }) &&
           clock.time(times.matching_ms, [&] { return t.match(anew); }) &&
           (clock.time(times.fingertips_ms, [&] { t.measure_tips(result); }),
            clock.time(times.pose_ms, [&] { return t.estimate_pose(result); }));
  };
  const auto look_at = [&](bool anew, bool where_expected) {
    return clock.time(times.segmentation_ms, [&] { return t.segment(where_expected); }) &&
           identify(anew);
  };
  // By colour alone; unless that is surely a hand, by place and edges too: the more hand-like wins.
  const auto look = [&](bool anew) {
    if (!clock.time(times.segmentation_ms, [&] { return t.read_neighbourhood(frame); }))
      return false;
    const bool seen = look_at(anew, false);
    const HandShape first = t.found;
    if (seen && first.deviation < t.config.shape.sure_deviation) return true;
    const auto tips = [](const HandShape& shape) {
      return std::ranges::count(shape.tip_seen, true);
    };
    if (look_at(anew, true) &&
        (!seen || (t.found.deviation < first.deviation && tips(t.found) >= tips(first))))
      return true;
    return seen && look_at(anew, false);
  };
  const auto look_at_outline = [&](bool anew) {
    t.colorless = true;
    return clock.time(times.segmentation_ms, [&] { return t.follow_outline(); }) && identify(anew);
  };
  const auto search = [&] {
    return clock.time(times.segmentation_ms, [&] { return t.find_anywhere(frame); });
  };
  // What the search finds is rough: its colours are learned and the hand is looked at again. If
  // that does not tell it from what surrounds it, what the search saw must do.
  const auto look_anew = [&] {
    const HandShape found = t.shape;
    bool seen = look(true);
    for (int again = 0; !seen && again < 2 && t.promising; ++again) {
      t.shape = t.to_input(t.found);
      t.learn(t.bins, t.region.mask(), t.found);
      seen = look(true);
    }
    if (!seen && found.deviation < t.config.shape.max_deviation) {
      t.shape = found;
      seen =
          clock.time(times.segmentation_ms, [&] { return t.adopt_found(frame); }) && identify(true);
    }
    if (seen)
      t.acquired_deviation = found.deviation;
    else
      t.forget_found();
    return seen;
  };
  bool seen = false;
  t.colorless = false;
  if (t.state == State::acquiring && search()) seen = look_anew();
  if (!seen && t.following) seen = look(false) || look_at_outline(false);
  if (!seen && (t.state == State::searching || t.state == State::lost)) {
    t.colorless = false;
    if (search()) {
      seen = look_anew();
    } else if (clock.time(times.segmentation_ms, [&] { return t.find_own_outline(); })) {
      seen = clock.time(times.segmentation_ms, [&] { return t.read_neighbourhood(frame); }) &&
             look_at_outline(true);
      if (!seen) t.forget_found();
    }
  }
  t.advance(seen);
  result.state = t.state;
  if (!seen) result.raw_pose.reset();
  t.contour_size = seen ? t.contour.size() : 0;
  for (int i = 0; i < t.contour_size; ++i) t.contour_px[i] = t.to_input(t.contour[i]);
  if (!seen) {
    result.tips = {};
    result.valleys = {};
  } else {
    result.layout = t.found.layout;
    clock.time(times.segmentation_ms, [&] { t.learn(t.bins, t.region.mask(), t.found); });
    // While a hand is acquired the filter settles; who asks for a pose gets it once it is believed.
    clock.time(times.filter_ms, [&] { t.filter_pose(result); });
    if (t.state != State::tracking) {
      result.raw_pose.reset();
      result.pose.reset();
    }
  }
  times.total_ms = clock.total_ms();
  return result;
}

std::optional<FilteredPose> HandTracker::predict(double time_s) const noexcept {
  if (impl_->state != State::tracking) return std::nullopt;
  return impl_->filter.predict(time_s);
}

std::span<const Eigen::Vector2f> HandTracker::contour_px() const noexcept {
  return {impl_->contour_px.data(), static_cast<std::size_t>(impl_->contour_size)};
}

HandMask HandTracker::mask() const noexcept {
  if (impl_->contour_size == 0) return {};
  const Mask& m = impl_->region.mask();
  // Colours are not needed between frames: their room holds the mask for who asks for it.
  auto* const bytes = reinterpret_cast<std::uint8_t*>(impl_->bins.bins.data());
  m.unpack(bytes);
  return {
      bytes, m.width, m.height, m.width, impl_->bins.x0_px, impl_->bins.y0_px, impl_->bins.step_px};
}

const HandModel& HandTracker::hand() const noexcept { return impl_->hand(impl_->found.layout); }

std::span<const std::int8_t> HandTracker::color_ratios() const noexcept {
  return impl_->skin.ratios();
}

SkinColors HandTracker::learned_colors() const {
  const SkinModel& skin = impl_->skin;
  return impl_->state == State::tracking ? skin.learned_colors()
                                         : skin.colors_of(impl_->trusted_skin);
}

void HandTracker::reset() noexcept { impl_->forget(); }

}  // namespace handyar
