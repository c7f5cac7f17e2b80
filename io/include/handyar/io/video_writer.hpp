// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <opencv2/videoio.hpp>
#include <string>

#include "handyar/io/pending_file.hpp"

namespace handyar::io {

/// Writes .mp4, .mkv or .mov (H.264 where there is an encoder, else MPEG-4) or .avi (MPEG-4). The
/// file takes its name on finish(). Throws Error.
class VideoWriter {
 public:
  VideoWriter(const std::string& path, int width_px, int height_px, double fps);

  /// `bgr` has the size given at the beginning. The video has a constant rate and keeps to the
  /// times of its frames all the same: where one comes late the one before is shown for longer (in
  /// a pause for ten seconds at most), where they come faster than the rate some are left out.
  void write(const cv::Mat& bgr, double time_s);
  /// Reads the file back before it takes its name: a full disk is found only so.
  void finish();

 private:
  void put(const cv::Mat& bgr);

  PendingFile file_;
  cv::VideoWriter writer_;
  double fps_, start_s_ = 0;
  std::int64_t frames_ = 0;
  cv::Mat last_, even_;
};

}  // namespace handyar::io
