// SPDX-License-Identifier: MIT
#include "handyar/paper/tracker.hpp"

#include <cmath>
#include <limits>

#include "handyar/paper/tip_pose.hpp"
#include "paper/fingertips.hpp"
#include "paper/hand_region.hpp"
#include "paper/matching.hpp"
#include "paper/skin_model.hpp"
#include "stage_clock.hpp"

namespace handyar::paper {

struct Tracker::Impl {
  Config config;
  HandModel given_hand, hand;
  Camera calibrated_camera, camera;
  SkinModel skin;
  HandRegion region;
  FingertipFinder finder;
  PoseFilter filter;

  // From frame to frame.
  double time_s = -std::numeric_limits<double>::infinity();
  State state = State::searching;
  bool region_found = false;
  int votes = 0, missed = 0;
  OrderedTips tips;
  TipAssignment seen{};
  std::optional<Eigen::Isometry3d> T_camera_hand;

  Impl(const Camera& c, const HandModel& h, const Config& cfg)
      : config(cfg),
        given_hand(h),
        hand(h),
        calibrated_camera(c),
        camera(c),
        skin(cfg.learn_frames),
        finder(config),
        filter(cfg.filter) {
    resize();
  }

  int step() const { return config.half_resolution ? 2 : 1; }
  void resize();
  FrameStatus admit(const ImageView& frame, double at_s) noexcept;
  void match(std::span<const Fingertip> found) noexcept;
  void vote(std::span<const Fingertip> found) noexcept;
  void follow(std::span<const Fingertip> found) noexcept;
  void lose() noexcept;
  void estimate(TrackResult& result) noexcept;
  void learn() noexcept;
  Eigen::Vector2d to_frame(const Eigen::Vector2f& mask_px) const {
    return step() * mask_px.cast<double>();
  }
};

void Tracker::Impl::resize() {
  region.resize(camera.width_px, camera.height_px, step());
  finder.reserve(4 * (camera.width_px + camera.height_px) / step());
}

FrameStatus Tracker::Impl::admit(const ImageView& frame, double at_s) noexcept {
  const FrameStatus status = check(frame);
  if (status != FrameStatus::ok) return status;
  if (!std::isfinite(at_s) || !(at_s > time_s)) return FrameStatus::time_not_increasing;
  time_s = at_s;
  if (frame.width_px != camera.width_px || frame.height_px != camera.height_px) {
    camera = calibrated_camera.scaled_to(frame.width_px, frame.height_px);
    lose();
    resize();
  }
  return FrameStatus::ok;
}

void Tracker::Impl::lose() noexcept {
  const bool was = state == State::tracking || state == State::lost;
  state = was ? State::lost : State::searching;
  votes = missed = 0;
  T_camera_hand.reset();
  filter.reset();
  skin.reset();
}

/// Five fingertips of the same layout in some frames in a row, and the hand is tracked (paper 2.3).
void Tracker::Impl::vote(std::span<const Fingertip> found) noexcept {
  const auto ordered = order_tips(found, region.palm());
  if (!ordered || (votes > 0 && ordered->layout != tips.layout)) {
    votes = 0;
    if (state == State::acquiring) state = State::searching;
    return;
  }
  tips = *ordered;
  seen = {0, 1, 2, 3, 4};
  ++votes;
  if (state == State::searching) state = State::acquiring;
  if (votes < config.vote_frames) return;
  state = State::tracking;
  missed = 0;
  hand = given_hand.for_layout(tips.layout);
}

void Tracker::Impl::follow(std::span<const Fingertip> found) noexcept {
  const float span = (tips.at[0] - tips.at[4]).norm();
  seen = match_tips(tips, found, static_cast<float>(config.max_move) * span);
  int matched = 0;
  for (int f = 0; f < kFingerCount; ++f) {
    if (seen[f] < 0) continue;
    tips.at[f] = found[seen[f]].at;
    ++matched;
  }
  constexpr int kLeastTips = 4, kMostMissed = 3;
  missed = matched < kLeastTips ? missed + 1 : 0;
  if (missed > kMostMissed) lose();
}

void Tracker::Impl::match(std::span<const Fingertip> found) noexcept {
  state == State::tracking ? follow(found) : vote(found);
}

void Tracker::Impl::estimate(TrackResult& result) noexcept {
  SeenTips observed;
  for (int f = 0; f < kFingerCount; ++f)
    if (seen[f] >= 0) observed[f] = to_frame(tips.at[f]);
  result.raw_pose =
      pose_from_tips(observed, hand, camera, config.tip_sigma_px * step(), T_camera_hand);
  if (result.raw_pose) T_camera_hand = result.raw_pose->T_camera_hand;
}

/// The verified hand's colours go back to the skin model (paper 2.1).
void Tracker::Impl::learn() noexcept {
  region.collect_colors();
  skin.learn(region.hand_colors(), region.background_colors());
}

Tracker::Tracker(const Camera& camera, const HandModel& hand, const Config& config)
    : impl_(std::make_unique<Impl>(camera, hand, config)) {}
Tracker::~Tracker() = default;
Tracker::Tracker(Tracker&&) noexcept = default;
Tracker& Tracker::operator=(Tracker&&) noexcept = default;

TrackResult Tracker::process(const ImageView& frame, double time_s) noexcept {
  Impl& t = *impl_;
  const StageClock clock(t.config.now_s);
  TrackResult result;
  result.time_s = time_s;
  result.scale_assumed = t.given_hand.scale_assumed();
  result.camera_assumed = t.calibrated_camera.assumed;
  result.status = t.admit(frame, time_s);
  if (result.status != FrameStatus::ok) return result;

  StageTimes& times = result.times;
  t.region_found = clock.time(times.segmentation_ms, [&] { return t.region.find(frame, t.skin); });
  std::span<const Fingertip> found;
  if (t.region_found) clock.time(times.fingertips_ms, [&] { found = t.finder.find(t.region); });
  clock.time(times.matching_ms, [&] { t.match(found); });
  if (t.state == State::tracking) {
    clock.time(times.pose_ms, [&] { t.estimate(result); });
    clock.time(times.filter_ms, [&] {
      if (result.raw_pose) t.filter.update(time_s, *result.raw_pose);
      result.pose = t.filter.predict(time_s);
    });
    if (t.region_found && t.missed == 0) clock.time(times.segmentation_ms, [&] { t.learn(); });
  }
  result.state = t.state;
  if (t.state == State::tracking || t.state == State::acquiring) {
    result.layout = t.tips.layout;
    for (int f = 0; f < kFingerCount; ++f) {
      result.tips[f].px = t.to_frame(t.tips.at[f]);
      result.tips[f].seen = t.seen[f] >= 0;
    }
  }
  times.total_ms = clock.total_ms();
  return result;
}

std::optional<FilteredPose> Tracker::predict(double time_s) const noexcept {
  if (impl_->state != State::tracking) return std::nullopt;
  return impl_->filter.predict(time_s);
}

HandMask Tracker::mask() const noexcept {
  if (!impl_->region_found) return {};
  const Mask& mask = impl_->region.mask();
  return {mask.pixels.data() + mask.at_index(0, 0),
          mask.width,
          mask.height,
          mask.width + 2,
          0,
          0,
          impl_->step()};
}

HandModel Tracker::hand() const noexcept { return impl_->hand; }

void Tracker::reset() noexcept {
  impl_->state = State::searching;
  impl_->lose();
  impl_->time_s = -std::numeric_limits<double>::infinity();
  impl_->hand = impl_->given_hand;
  impl_->region_found = false;
}

}  // namespace handyar::paper
