// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string>

#include "handyar/tracker.hpp"

namespace handyar::cli {

/// What the frames of a run, or of the last second of it, say about why no hand is tracked.
class Diagnosis {
 public:
  void look(const cv::Mat& bgr, const TrackResult& result);

  /// What was seen and what is missing, in a line; empty when a hand was tracked. `hand_file`: the
  /// one that was given, if any.
  std::string missing(const std::string& hand_file) const;

 private:
  std::int64_t frames_ = 0, tracked_ = 0, acquiring_ = 0;
  std::int64_t dark_ = 0, grey_ = 0, filled_ = 0, skin_ = 0;
};

}  // namespace handyar::cli
