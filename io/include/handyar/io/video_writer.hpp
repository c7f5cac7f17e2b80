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

  /// `bgr` has the size given at the beginning.
  void write(const cv::Mat& bgr);
  /// Reads the file back before it takes its name: a full disk is found only so.
  void finish();

 private:
  PendingFile file_;
  cv::VideoWriter writer_;
  std::int64_t frames_ = 0;
};

}  // namespace handyar::io
