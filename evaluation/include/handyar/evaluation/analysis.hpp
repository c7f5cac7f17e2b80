// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "handyar/evaluation/accuracy.hpp"
#include "handyar/evaluation/dynamics.hpp"
#include "handyar/evaluation/recording.hpp"

namespace handyar::evaluation {

/// Reprojection errors at the board's corners, one a frame (px rms, NaN where there is none); a
/// list is empty where it cannot be known at all.
struct BoardErrors {
  std::vector<double> blocks_px;  ///< thing-to-board fitted on alternating blocks of frames
  std::vector<double> exact_px;   ///< thing-to-board and the board's pose known from truth
};

struct TrackAnalysis {
  std::vector<FrameError> errors;  ///< empty without truth
  BoardErrors raw, filtered;
};

/// A recording and what it comes to.
struct Analysis {
  Recording recording;
  std::vector<TrackAnalysis> tracks;  ///< one for each of the recording's
  std::vector<BoardErrors> markers;   ///< one for each of the recording's
  std::vector<double> own_px;         ///< the board projected by its own pose
  std::vector<std::string> unknown;   ///< what cannot be said of this sequence, and why

  const TrackAnalysis& main_track() const { return tracks.front(); }
  bool has_truth() const { return recording.sequence.truth.has_value(); }
  bool has_board() const;  ///< seen in at least one frame
};

Analysis analyse(Recording recording);

/// The per-frame errors under their column names, the columns of errors.csv.
struct ErrorColumns {
  std::vector<std::string> states;
  std::vector<std::string> names;
  std::vector<std::vector<double>> values;  ///< one list a name, one value a frame

  const std::vector<double>* find(const std::string& name) const;
};
ErrorColumns error_columns(const Analysis& analysis);

/// Writes errors.csv: a row for each frame of each sequence. Throws io::Error.
void write_errors_csv(const std::string& file, const std::vector<Analysis>& analyses);

}  // namespace handyar::evaluation
