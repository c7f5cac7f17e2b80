// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "handyar/camera.hpp"
#include "handyar/config.hpp"
#include "handyar/hand_model.hpp"
#include "handyar/image_view.hpp"
#include "handyar/pose.hpp"
#include "handyar/pose_filter.hpp"

namespace handyar {

enum class State : std::uint8_t {
  searching,  ///< no hand
  acquiring,  ///< fingertips seen, not yet confirmed
  tracking,
  lost  ///< was tracking, trying to recover
};
std::string_view name(State state) noexcept;

/// What each stage took, in milliseconds; all zero unless Config::now_s is set.
struct StageTimes {
  double segmentation_ms = 0, fingertips_ms = 0, matching_ms = 0, pose_ms = 0, filter_ms = 0;
  double total_ms = 0;
};

/// One fingertip in pixels of the input frame.
struct Tip {
  Eigen::Vector2d px = Eigen::Vector2d::Zero();
  bool seen = false;
  /// Not seen, or refused because the finger came out much too long or short: `px` is where the
  /// hand's other points put it, good to some millimetres. Neither: `px` is meaningless.
  bool inferred = false;

  bool known() const noexcept { return seen || inferred; }
};

/// The axis of a finger, the line in the middle between its sides, in pixels of the input frame.
struct FingerAxis {
  Eigen::Vector2d end_px = Eigen::Vector2d::Zero();   ///< a place on it near the fingertip
  Eigen::Vector2d root_px = Eigen::Vector2d::Zero();  ///< and one near the valleys
  bool seen = false;                                  ///< false: the rest is meaningless
};

/// Everything known of the hand in one frame.
struct TrackResult {
  FrameStatus status = FrameStatus::ok;  ///< anything but ok: the frame was not processed
  double time_s = 0;
  State state = State::searching;
  std::optional<Layout> layout;           ///< while acquiring and tracking
  std::array<Tip, kFingerCount> tips;     ///< in finger order; while acquiring the best so far
  std::array<Tip, kValleyCount> valleys;  ///< valley i between finger i and i + 1
  std::array<FingerAxis, kFingerCount> axes;
  std::optional<PoseEstimate> raw_pose;  ///< from this frame alone, before the filter
  std::optional<FilteredPose> pose;      ///< filtered, at this frame's time
  StageTimes times;
  bool scale_assumed = false;   ///< the hand was not measured: lengths are an average adult's
  bool camera_assumed = false;  ///< the camera was not calibrated
};

/// The hand region of the last frame as a binary image. Pixel (u, v) of the mask covers the input
/// pixels from (x0_px + u * step_px, y0_px + v * step_px), `step_px` each way; 255 hand, 0 not.
struct HandMask {
  const std::uint8_t* data = nullptr;
  int width = 0, height = 0;
  std::ptrdiff_t stride_bytes = 0;
  int x0_px = 0, y0_px = 0, step_px = 1;
};

/// The paper's Figure 2: frame and time in, state and pose out.
///
///     HandTracker tracker(camera, average_adult_hand());
///     TrackResult r = tracker.process(frame, time_s);
///     if (r.pose) draw(r.pose->T_camera_hand);
///
/// All memory is taken by the constructor and the first frame of a new size; after that process()
/// allocates nothing, throws nothing, reads no clock and logs nothing. One thread at a time.
class HandTracker {
 public:
  HandTracker(const Camera& camera, const HandModel& hand, const Config& config = {});
  ~HandTracker();
  HandTracker(HandTracker&&) noexcept;
  HandTracker& operator=(HandTracker&&) noexcept;

  /// Times must increase from frame to frame. A frame without a hand gives a state, never an old
  /// pose. The camera is rescaled when frames of another size arrive.
  TrackResult process(const ImageView& frame, double time_s) noexcept;

  /// The pose expected at a later time, for display; empty when not tracking.
  std::optional<FilteredPose> predict(double time_s) const noexcept;

  /// Contour of the hand region of the last frame in input pixels, ordered; empty without a hand.
  /// Valid until the next process().
  std::span<const Eigen::Vector2f> contour_px() const noexcept;

  /// Hand region of the last frame; empty (width 0) without a hand. Valid until the next process();
  /// written anew by each call, so not for two threads at once.
  HandMask mask() const noexcept;

  /// The hand model in the layout now tracked (mirrored when needed).
  const HandModel& hand() const noexcept;

  /// What the next frame will be segmented with: by colour bin, the log likelihood ratio of hand
  /// against background in eighths of a nat. For looking at; changes with every process().
  std::span<const std::int8_t> color_ratios() const noexcept;

  /// Colours of the tracked hand over the last frames, or as it was last tracked; empty when it
  /// never was. What Config::skin.personal takes. Takes memory: not for every frame.
  SkinColors learned_colors() const;

  /// Forgets hand and colours, as newly made.
  void reset() noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace handyar
