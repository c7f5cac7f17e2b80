// SPDX-License-Identifier: MIT
#include "handyar/tracker.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "tracker_impl.hpp"

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

void HandTracker::Impl::forget() noexcept {
  skin.reset();
  skin.keep(trusted_skin);
  search.reset();
  filter.reset();
  time_s = -std::numeric_limits<double>::infinity();
  state = State::searching;
  following = false;
  noisy = false;
  own_shape.reset();
  contour_size = 0;
  seen_frames = 0;
  relief_evidence = planar_evidence = 0;
  tracked_s = filtered_s = -std::numeric_limits<double>::infinity();
}

void HandTracker::Impl::prepare(const ImageView& frame) {
  if (frame.width_px == width_px && frame.height_px == height_px) return;
  width_px = frame.width_px;
  height_px = frame.height_px;
  camera = calibrated_camera.scaled_to(width_px, height_px);
  const int longer_px = std::max(width_px, height_px), step = tracking_step();
  const int width = width_px / step, height = height_px / step, longer = longer_px / step;
  bins.bins.resize(width * height);
  chroma.reserve(width);
  stages.reserve(width * height, longer);
  expectation.ratios.resize((width / 2 + 1) * (height / 2 + 1));  // cells of 2 or more
  silhouette.reserve(width * height, longer);
  const int coarse = search_step();
  search.reserve((width_px / coarse) * (height_px / coarse), longer_px / coarse);
  contour_px.resize(stages.contour.room());
  forget();
}

/// The states: when a hand is believed, and when it is given up.
void HandTracker::Impl::advance(bool seen) noexcept {
  const AcquisitionConfig& limits = config.acquisition;
  const bool known = time_s - tracked_s < limits.remember_s;
  if (seen) {
    const HandShape now = to_input(found);
    const bool resumed = following && state == State::lost;
    if (following) {
      velocity_px_s = (now.palm() - seen_palm_px) / static_cast<float>(time_s - seen_s);
    } else {
      // A hand that was turned over shows the same heights from the other side.
      if (!known)
        relief_evidence = 0;
      else if (layout_before != found.layout)
        relief_evidence = -relief_evidence;
      layout_before = found.layout;
      if (!known || own_shape.layout() != found.layout) own_shape.reset();
      first_seen_s = time_s;
      seen_frames = 0;
      filter.reset();
    }
    ++seen_frames;
    const bool confirmed =
        time_s - first_seen_s > (known ? limits.reconfirm_s : limits.confirm_s) - 1e-6 &&
        seen_frames >= (known ? limits.reconfirm_frames : limits.confirm_frames);
    if (state != State::tracking) state = resumed || confirmed ? State::tracking : State::acquiring;
    if (!colorless) colored_s = time_s;
    if (state == State::tracking) {
      const auto all = [](const auto& flags) {
        return std::ranges::all_of(flags, std::identity());
      };
      if (!colorless &&
          found.deviation < config.shape.own_deviation_share * config.shape.max_deviation &&
          all(found.tip_seen) && all(found.valley_seen))
        own_shape.learn(found, static_cast<float>((time_s - seen_s) / config.shape.own_memory_s));
      tracked_s = time_s;
    }
    shape = now;
    seen_palm_px = now.palm();
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
  const bool seen = t.look_at_hand(frame, clock, result);
  t.advance(seen);
  result.state = t.state;
  t.contour_size = seen ? t.stages.contour.size() : 0;
  for (int i = 0; i < t.contour_size; ++i) t.contour_px[i] = t.to_input(t.stages.contour[i]);
  if (seen) {
    result.layout = t.found.layout;
    clock.time(result.times.segmentation_ms,
               [&] { t.learn(t.bins, t.stages.region.mask(), t.found); });
    clock.time(result.times.filter_ms, [&] { t.filter_pose(result); });
  } else {
    result.tips = {};
    result.valleys = {};
    result.axes = {};
  }
  // While a hand is acquired the filter settles; who asks for a pose gets it once it is believed.
  if (t.state != State::tracking) {
    result.raw_pose.reset();
    result.pose.reset();
  }
  result.times.total_ms = clock.total_ms();
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
  const Mask& m = impl_->stages.region.mask();
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
