// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "handyar/evaluation/board_error.hpp"
#include "handyar/evaluation/sequence.hpp"
#include "handyar/tracker.hpp"

namespace handyar::evaluation {

/// Names of the methods: the default one, and the paper's with its two kinds of fingertips.
inline constexpr const char* kFigure = "figure";
inline constexpr const char* kPaper = "paper, ellipse";
inline constexpr const char* kPaperCurvature = "paper, curvature";

/// What the tracker gave with one setting, frame by frame.
struct Track {
  std::string method;  ///< kFigure, kPaper or kPaperCurvature
  bool half_resolution = false;
  std::vector<TrackResult> results;
  HandModel hand = {};  ///< as it was known at the end
};

/// What a marker system gave, frame by frame: detection with pose.
struct MarkerTrack {
  std::string system;  ///< "ArUco" or "AprilTag"
  bool half_resolution = false;
  Poses T_camera_marker;
  std::vector<double> ms;  ///< colour conversion, detection and pose
};

/// Everything measured on one sequence, all of it on the same frames in the same run.
struct Recording {
  Sequence sequence;
  std::vector<std::int64_t> frame_index;  ///< in the video; a series of pictures may have gaps
  std::vector<double> time_s;
  std::vector<Track> tracks;  ///< the first is the default setting at full resolution
  std::vector<MarkerTrack> markers;
  std::vector<std::optional<BoardView>> board_views;
  std::vector<std::vector<Eigen::Vector2f>> contours_px;  ///< of tracks[0]
  std::string broken_off;  ///< why the video ended early; empty: it did not

  const Track& main_track() const { return tracks.front(); }
  const MarkerTrack* find_marker(const std::string& system, bool half_resolution) const;
};

/// Called after each frame with the number of frames done and promised (0: unknown).
using Progress = std::function<void(int done, int promised)>;

/// What sees the frames: everything, or the default method alone.
enum class Methods { all, figure_only };

/// Reads the video once and lets everything see each frame: the tracker of either method, the
/// paper's at both resolutions, both marker systems at both resolutions, the board. Frames before
/// `first_frame` of the video are passed over, as if the camera had been off.
Recording record(const Sequence& sequence, Methods methods, const Progress& progress = {},
                 std::int64_t first_frame = 0);

}  // namespace handyar::evaluation
