// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>

namespace handyar::io {

/// Writes pictures without loss and with their times (to the millisecond), to be replayed as they
/// were: FFV1 in Matroska. The file takes its name on finish(). Throws Error.
class Recording {
 public:
  /// `path` must end in .mkv.
  Recording(const std::string& path, int width_px, int height_px);
  ~Recording();
  Recording(Recording&&) noexcept;

  /// `bgr` has the size given at the beginning; times increase.
  void write(const cv::Mat& bgr, double time_s);
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace handyar::io
