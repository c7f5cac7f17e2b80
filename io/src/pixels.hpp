// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core/mat.hpp>

#include "libav.hpp"

namespace handyar::io {

/// Gives a picture of these the memory that it needs, unless it has it; false when there is none.
/// There is more of it behind the last row, where PixelConverter reads on.
bool make_room(AVFrame& picture, AVPixelFormat format, int width_px, int height_px);

/// From the pixels that libavcodec gives to those of a cv::Mat, and back.
class PixelConverter {
 public:
  enum class Care {
    fast,  ///< for videos
    exact  ///< for pictures: rounded, and colours between their samples much as libjpeg has them
  };
  explicit PixelConverter(Care care) : care_(care) {}

  /// Fills `to` with the pixels of `from` as `format`: BGR24, RGBA or GRAY8. False when that is
  /// impossible. `from` has its memory from make_room() or libavcodec.
  bool to_mat(const AVFrame& from, AVPixelFormat format, cv::Mat& to);

  /// Fills `to`, whose buffers are there, with the pixels of `from`, which are of `format`.
  bool to_frame(const cv::Mat& from, AVPixelFormat format, AVFrame& to);

 private:
  bool fill(const AVFrame& from, AVPixelFormat format, int depth, cv::Mat& to);
  bool prepare(int width_px, int height_px, AVPixelFormat from, AVPixelFormat to);

  Care care_;
  Libav<SwsContext> scaler_;
  cv::Mat wide_;
  Libav<AVFrame> padded_{av_frame_alloc()};
};

}  // namespace handyar::io
