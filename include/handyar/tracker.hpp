// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

#include "handyar/api.h"
#include "handyar/camera.hpp"
#include "handyar/config.hpp"
#include "handyar/gesture.hpp"
#include "handyar/hand_model.hpp"
#include "handyar/image_view.hpp"
#include "handyar/pose.hpp"

namespace handyar {

enum class State : std::uint8_t {
  searching,  ///< no hand
  acquiring,  ///< fingertips seen, not yet confirmed
  tracking,
  lost  ///< was tracking, trying to recover
};
[[nodiscard]] HANDYAR_API std::string_view name(State state) noexcept;

/// What each stage took, in milliseconds; all zero unless Config::now_s is set. Segmentation is
/// looking for the hand, or for how surely it is one; pose is laying the figure. Fingertips and
/// matching are stages of the paper's method alone.
struct StageTimes {
  double segmentation_ms = 0, fingertips_ms = 0, matching_ms = 0, pose_ms = 0, filter_ms = 0;
  double total_ms = 0;
};

/// One fingertip in pixels of the input frame.
struct Tip {
  Eigen::Vector2d px = Eigen::Vector2d::Zero();
  bool seen = false;
  /// Outside the frame: `px` is where the rest of the hand puts it. Neither: meaningless.
  bool inferred = false;

  [[nodiscard]] bool known() const noexcept { return seen || inferred; }
};

/// How a finger stands against the person's rest posture; standard deviations beside.
struct FingerState {
  double abduction_rad = 0, abduction_sigma_rad = 0;  ///< in the palm plane, towards the thumb
  double flexion_rad = 0, flexion_sigma_rad = 0;      ///< towards the palm
};

/// Everything known of the hand in one frame.
struct TrackResult {
  FrameStatus status = FrameStatus::ok;  ///< anything but ok: the frame was not processed
  double time_s = 0;
  State state = State::searching;
  bool doubtful = false;               ///< tracking, but the pose is not to be relied on
  std::optional<Layout> layout;        ///< while a hand is followed, open or folded
  std::optional<Face> face;            ///< palm or back, as far as it is told
  std::array<Tip, kFingerCount> tips;  ///< in finger order; while acquiring the best so far
  std::array<Tip, kValleyCount> webs;  ///< web i between finger i and i + 1
  std::array<FingerState, kFingerCount> fingers;  ///< while an open hand is followed
  /// Of each of the two last joints of the thumb, in the palm plane, away from the fingers.
  double thumb_bend_rad = 0;
  std::optional<PoseEstimate> raw_pose;       ///< from this frame alone, before the filter
  std::optional<FilteredPose> pose;           ///< filtered, at this frame's time
  Gesture gesture = Gesture::open;            ///< held for a tenth of a second at least
  std::optional<GestureEvent> gesture_event;  ///< that this frame completed
  /// While fingers are folded there is no `pose`; this is where the palm is, so that an object
  /// stays on it. Less sure than a pose; there is none of a hand that was not seen open before.
  std::optional<FilteredPose> held_pose;
  StageTimes times;
  bool scale_assumed = false;   ///< the hand was not measured: lengths are an average adult's
  bool camera_assumed = false;  ///< the camera was not calibrated
};

/// The hand in the last frame as a binary image. Pixel (u, v) of the mask covers the input
/// pixels from (x0_px + u * step_px, y0_px + v * step_px), `step_px` each way; 255 hand, 0 not.
struct HandMask {
  const std::uint8_t* data = nullptr;
  int width = 0, height = 0;
  std::ptrdiff_t stride_bytes = 0;
  int x0_px = 0, y0_px = 0, step_px = 1;
};

struct FrameEvidence;

/// Frame and time in, state and pose out. Two of them follow two hands, see share_view().
///
///     HandTracker tracker(camera, average_adult_hand());
///     TrackResult r = tracker.process(frame, time_s);
///     if (r.pose) draw(r.pose->T_camera_hand);
///
/// All memory is taken by the constructor and the first frame of a new size; after that process()
/// allocates nothing, throws nothing, reads no clock and logs nothing. One thread at a time.
class HANDYAR_API HandTracker {
 public:
  HandTracker(const Camera& camera, const HandModel& hand, const Config& config = {});
  ~HandTracker();
  HandTracker(HandTracker&&) noexcept;
  HandTracker& operator=(HandTracker&&) noexcept;

  /// Times must increase from frame to frame. A frame without a hand gives a state, never an old
  /// pose. The camera is rescaled when frames of another size arrive.
  TrackResult process(const ImageView& frame, double time_s) noexcept;

  /// The pose expected at a later time, for display; empty when not tracking.
  [[nodiscard]] std::optional<FilteredPose> predict(double time_s) const noexcept;

  /// The figure's silhouette in the last frame; empty (width 0) without a hand. Valid until the
  /// next process(); written anew by each call, so not for two threads at once.
  [[nodiscard]] HandMask mask() const noexcept;

  /// The person's hand as far as it was learned, in the layout last tracked.
  [[nodiscard]] const HandModel& hand() const noexcept;

  /// What the last frame showed (stages/evidence.hpp). Valid until the next process().
  [[nodiscard]] const FrameEvidence& evidence() const noexcept;

  /// Forgets hand and colours, as newly made.
  void reset() noexcept;

 private:
  friend HANDYAR_API void share_view(HandTracker& first, HandTracker& second) noexcept;
  struct HANDYAR_INTERNAL Impl;
  std::unique_ptr<Impl> impl_;
};

/// Two trackers of one camera for two hands, each with a model, settings and colours of its own:
///
///     std::array hands{HandTracker(camera, hand), HandTracker(camera, hand)};
///     share_view(hands[0], hands[1]);
///     for (HandTracker& tracker : hands) show(tracker.process(frame, time_s));
///
/// From now on each leaves the hand that the other follows alone, so that they do not change hands
/// when these pass each other. Every frame is for both, the first one first, in one thread. While
/// neither has a hand only the first searches; while one has, the other searches some frames.
/// It ends when one of them is destroyed.
HANDYAR_API void share_view(HandTracker& first, HandTracker& second) noexcept;

}  // namespace handyar
