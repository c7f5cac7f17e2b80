// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core/mat.hpp>

#include "libav.hpp"

namespace handyar::io {

/// From the pixels that libavcodec gives to those of a cv::Mat, and back.
class PixelConverter {
 public:
  enum class Care {
    fast,  ///< for videos
    exact  ///< for pictures: rounded, and colours between their samples much as libjpeg has them
  };
  explicit PixelConverter(Care care) : care_(care) {}

  /// Fills `to` with the pixels of `from` as `format`: BGR24, RGBA or GRAY8. False when that is
  /// impossible.
  bool to_mat(const AVFrame& from, AVPixelFormat format, cv::Mat& to);

  /// Fills `to`, whose buffers are there, with the pixels of `from`, which are of `format`.
  bool to_frame(const cv::Mat& from, AVPixelFormat format, AVFrame& to);

 private:
  bool fill(const AVFrame& from, AVPixelFormat format, int depth, cv::Mat& to);
  bool prepare(int width_px, int height_px, AVPixelFormat from, AVPixelFormat to);

  Care care_;
  Libav<SwsContext> scaler_;
  cv::Mat wide_;
};

}  // namespace handyar::io
