// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "handyar/evaluation/recording.hpp"
#include "handyar/evaluation/tables.hpp"

namespace handyar::evaluation {

/// A photograph of five spread fingers.
struct Still {
  std::string file;       ///< as the list names it
  std::string picture;    ///< its path
  std::string skin_tone;  ///< empty: unknown
  std::array<Eigen::Vector2d, kFingerCount> tips_px;
};

/// A list (CSV) with columns file, thumb_x ... little_y in pixels as stored, and optionally
/// skin_tone; the pictures beside it. Throws io::Error, also when one of them is missing.
std::vector<Still> read_stills(const std::string& list);

/// What became of one of them.
struct StillResult {
  enum class Outcome { right, wrong, not_found } outcome;
  std::string file;
  std::string source;  ///< the file's name up to the first underscore
  std::string skin_tone;
  double largest_of_span = kUnknown;  ///< largest tip error over the thumb-little span
  std::vector<double> of_span;        ///< the five, when right
};

/// Each is letterboxed to 640x480 and held for 25 frames with slight noise (seeded: the same each
/// time). The last five tips found must all be within 0.2 of the thumb-little span. Throws
/// io::Error when a picture cannot be read.
std::vector<StillResult> track_stills(const std::vector<Still>& stills,
                                      const Progress& progress = {});

/// Rows: all, each source, each skin tone.
Table stills_table(const std::vector<StillResult>& results);

/// Writes stills.csv: a row for each photograph. Throws io::Error.
void write_stills_csv(const std::string& file, const std::vector<StillResult>& results);

}  // namespace handyar::evaluation
