// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "handyar/evaluation/recording.hpp"
#include "handyar/evaluation/tables.hpp"

namespace handyar::evaluation {

/// What became of one photograph of five spread fingers.
struct StillResult {
  enum class Outcome { right, wrong, not_found } outcome;
  std::string file;
  std::string source;                 ///< the file's name up to the first underscore
  std::string skin_tone;              ///< column skin_tone of the list; empty: unknown
  double largest_of_span = kUnknown;  ///< largest tip error over the thumb-little span
  std::vector<double> of_span;        ///< the five, when right
};

/// Each photograph of the list (columns file, width, height, thumb_x ... little_y, optionally
/// skin_tone; the pictures beside it) is letterboxed to 640x480 and held for 25 frames with slight
/// noise (seeded: the same each time). The last five tips found must all be within 0.2 of the
/// thumb-little span. Pictures that are missing are left out. Throws io::Error.
std::vector<StillResult> track_stills(const std::string& list, const SkinColors& skin = {},
                                      const Progress& progress = {});

/// Rows: all, each source, each skin tone.
Table stills_table(const std::vector<StillResult>& results);

/// Writes stills.csv: a row for each photograph. Throws io::Error.
void write_stills_csv(const std::string& file, const std::vector<StillResult>& results);

}  // namespace handyar::evaluation
