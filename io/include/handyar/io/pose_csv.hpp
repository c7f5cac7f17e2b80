// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>

#include "handyar/io/pending_file.hpp"
#include "handyar/tracker.hpp"

namespace handyar::io {

/// The header row of a pose file, without line end (docs/formats.md says what each column is).
extern const std::string_view kPoseCsvHeader;

/// One row without line end. The same for the same result whatever the locale; the columns in
/// milliseconds stay empty without `timings`. `hand`: 1, of two hands 1 or 2.
std::string pose_csv_row(std::int64_t frame, const TrackResult& result, bool timings = true,
                         int hand = 1);

/// Writes a pose file row by row; it takes its name on finish(). Throws Error.
class PoseCsvWriter {
 public:
  explicit PoseCsvWriter(const std::string& path, bool timings = true);
  void write(std::int64_t frame, const TrackResult& result, int hand = 1);
  void finish();

 private:
  void put(const std::string& line);

  PendingFile file_;
  std::ofstream stream_;
  bool timings_;
};

}  // namespace handyar::io
