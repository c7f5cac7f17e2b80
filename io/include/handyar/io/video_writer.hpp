// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>

namespace handyar::io {

/// Writes .mp4, .mkv or .mov (H.264 where there is an encoder, else MPEG-4) or .avi (MPEG-4). The
/// file takes its name on finish(). Throws Error.
class VideoWriter {
 public:
  VideoWriter(const std::string& path, int width_px, int height_px, double fps);
  ~VideoWriter();
  VideoWriter(VideoWriter&&) noexcept;

  /// `bgr` has the size given at the beginning. The video has a constant rate and keeps to the
  /// times of its frames all the same: where one comes late the one before is shown for longer (in
  /// a pause for ten seconds at most), where they come faster than the rate some are left out.
  void write(const cv::Mat& bgr, double time_s);
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace handyar::io
