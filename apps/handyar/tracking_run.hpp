// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "command.hpp"
#include "debug_pictures.hpp"
#include "handyar/io/frame_source.hpp"
#include "handyar/paper/any_tracker.hpp"

namespace handyar::cli {

/// What to draw on a frame after the annotation: an object on the hand, which covers the lines on
/// it. Called for every frame in turn, also when no picture is wanted.
using Overlay = std::function<void(cv::Mat& bgr, std::int64_t frame, const AnyTracker& tracker,
                                   const Camera& camera, const TrackResult& result)>;

/// What else looks at a frame and its first hand: called for every frame in turn, before anything
/// is drawn on it.
using Observer =
    std::function<void(const cv::Mat& bgr, std::int64_t frame, const AnyTracker& tracker,
                       const Camera& camera, const TrackResult& result, bool live)>;

/// One run of the tracker over an input; an empty name: not wanted.
struct TrackingRun {
  std::string input;
  io::CameraSettings camera_settings;
  std::string camera_file, hand_file;
  std::optional<double> readout_ms;  ///< instead of the camera file's
  std::string poses_out, video_out, events_out, record_out;
  std::string debug_folder;  ///< for the stages of `debug_frames`
  FrameSet debug_frames;
  bool show = false;
  bool timings = true;
  Method method = Method::figure;
  int hands = 1;               ///< at once, at most two; Method::paper follows one
  Config config;               ///< of Method::figure
  paper::Config paper_config;  ///< of Method::paper
  Observer observer;
  std::array<Overlay, 2> overlays;    ///< of the first hand, and of the second
  std::function<void()> next_object;  ///< what the key for another object does
  bool annotated = true;              ///< contour, fingertips and axes on the pictures
  bool mirrored = false;              ///< the pictures, as one sees oneself
};

/// The options --camera, --readout-ms and --hand of a subcommand that tracks.
void add_tracker_files(CLI::App* options, TrackingRun& run);

/// The option --video; `what`: "Write the video".
void add_video(CLI::App* options, TrackingRun& run, const std::string& what);

struct Summary {
  std::int64_t frames = 0, tracked = 0;
  std::optional<std::int64_t> both;  ///< where two hands were asked for: frames with both tracked
  std::int64_t last_frame = 0;       ///< its number
  std::optional<double> median_ms;   ///< of the tracker, a frame; empty without timings
  std::string missing;               ///< why nothing was tracked, where that can be told
  int signal = 0;                    ///< what ended the run early, or 0
  bool live = false;
  bool ended_early = false;  ///< by a signal or at the window
};

/// Runs it. Faults of inputs and outputs come as io::Error; what was read before such a fault is
/// kept in the outputs.
Summary track(const TrackingRun& run);

/// "300 frames, 97.3 % tracked, median 1.42 ms a frame"; a second line when nothing was tracked.
std::string describe(const Summary& summary);

/// The exit code: 128 + signal for a file that was not finished; the end of a live camera is always
/// somebody's wish, so it is 0.
int exit_code(const Summary& summary) noexcept;

}  // namespace handyar::cli
