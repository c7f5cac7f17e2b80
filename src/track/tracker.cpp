// SPDX-License-Identifier: MIT
#include "handyar/tracker.hpp"

#include "stage_clock.hpp"
#include "track/tracker_state.hpp"

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

HandTracker::HandTracker(const Camera& camera, const HandModel& hand, const Config& config)
    : impl_(std::make_unique<Impl>(camera, hand, config)) {}
HandTracker::~HandTracker() = default;
HandTracker::HandTracker(HandTracker&&) noexcept = default;
HandTracker& HandTracker::operator=(HandTracker&&) noexcept = default;

TrackResult HandTracker::process(const ImageView& frame, double time_s) noexcept {
  Impl& t = *impl_;
  const StageClock clock(t.config.user.now_s);
  TrackResult result;
  result.time_s = time_s;
  result.scale_assumed = t.hand.scale_assumed();
  result.camera_assumed = t.calibrated_camera.assumed;
  result.status = t.admit(frame, time_s);
  if (result.status != FrameStatus::ok) return result;
  const double dt_s = time_s - t.seen.time_s;
  t.seen.time_s = time_s;

  t.candidates = {};
  if (t.has_hand()) clock.time(result.times.pose_ms, [&] { t.follow(frame, dt_s); });
  clock.time(result.times.pose_ms, [&] { t.compare_postures(frame, dt_s); });
  clock.time(result.times.segmentation_ms, [&] { t.look(frame); });
  t.believe(dt_s);
  if (t.in_view()) clock.time(result.times.filter_ms, [&] { t.filter(dt_s, result); });
  if (t.has_hand()) t.learn(frame, dt_s);
  t.report(result);
  result.times.total_ms = clock.total_ms();
  return result;
}

std::optional<FilteredPose> HandTracker::predict(double time_s) const noexcept {
  if (impl_->seen.state != State::tracking) return std::nullopt;
  return impl_->seen.filter.predict(time_s);
}

HandMask HandTracker::mask() const noexcept { return impl_->draw_mask(); }

const HandModel& HandTracker::hand() const noexcept { return impl_->learned_hand; }

const FrameEvidence& HandTracker::evidence() const noexcept { return impl_->evidence; }

void HandTracker::reset() noexcept { impl_->reset(); }

}  // namespace handyar
