// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "handyar/pose_filter.hpp"
#include "handyar/tracker.hpp"

/// The method of T. Lee and T. Höllerer, "Handy AR" (ISWC 2007), as written: for its tables, for
/// teaching, and to be compared with. docs/method.md tells where each of its sections is.
namespace handyar::paper {

enum class FingertipMethod : std::uint8_t {
  curvature,  ///< the contour's point of highest curvature
  ellipse     ///< the end of an ellipse fitted around it
};

struct Config {
  bool half_resolution = false;  ///< of each side of the frame (paper Table 1)
  int learn_frames = 5;          ///< n frames over which colours are learned (paper 2.1)
  double min_cosine = 0.5;       ///< of the angle at a fingertip, at one scale at least (paper 2.2)
  FingertipMethod fingertips = FingertipMethod::ellipse;
  int vote_frames = 10;       ///< frames in a row that must show five fingertips (paper 2.3)
  double max_move = 0.3;      ///< of a fingertip between frames, in thumb-little spans (paper 2.3)
  double tip_sigma_px = 1.0;  ///< error of a fingertip in mask pixels, for the covariance
  PoseFilterConfig filter;    ///< paper 2.5

  /// Clock for StageTimes, in seconds; null: times stay zero. Nothing else depends on it.
  double (*now_s)() = nullptr;
};

/// Frame and time in, state and pose out, as HandTracker.
class Tracker {
 public:
  Tracker(const Camera& camera, const HandModel& hand, const Config& config = {});
  ~Tracker();
  Tracker(Tracker&&) noexcept;
  Tracker& operator=(Tracker&&) noexcept;

  TrackResult process(const ImageView& frame, double time_s) noexcept;
  std::optional<FilteredPose> predict(double time_s) const noexcept;
  /// The hand region of the last frame; empty without one. Valid until the next process().
  HandMask mask() const noexcept;
  /// The hand as given, in the layout last seen.
  HandModel hand() const noexcept;
  void reset() noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace handyar::paper
