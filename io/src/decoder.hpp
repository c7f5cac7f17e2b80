// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>

namespace handyar::io {

/// The pictures of a video file as libavformat finds and libavcodec decodes them.
class Decoder {
 public:
  /// Throws Error when there is no video in the file that can be decoded.
  explicit Decoder(const std::string& path);
  ~Decoder();

  enum class Step {
    picture,  ///< a sound one
    damage,   ///< something could not be read or decoded; there may be more behind it
    end
  };
  /// Fills `bgr` with the next picture as it is stored, and `time_s` with its time in the container
  /// (not a number: it has none).
  Step next(cv::Mat& bgr, double& time_s);

  double fps() const;                ///< mean or nominal; 0: unknown
  std::int64_t frame_count() const;  ///< as the container promises; 0: unknown
  int clockwise_deg() const;         ///< how far to turn a picture so that it stands upright

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// How many frames are found in a video file, without decoding any.
std::int64_t count_packets(const std::string& path);

}  // namespace handyar::io
