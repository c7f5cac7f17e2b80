// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "driver_calls.hpp"
#include "handyar/io/frame_source.hpp"
#include "pixels.hpp"
#include "still_decoder.hpp"

namespace handyar::io {

/// A camera as Linux's V4L2 has it, from opened to closed.
class V4l2Camera {
 public:
  /// Throws Error. The driver may give another size and rate than those asked for.
  V4l2Camera(const std::string& path, const CameraSettings& settings, DriverCalls& calls);
  ~V4l2Camera();
  V4l2Camera(const V4l2Camera&) = delete;
  V4l2Camera& operator=(const V4l2Camera&) = delete;

  /// Waits for the next picture and when it was taken, by the driver's clock. What cannot be
  /// decoded is left out. False when the camera gives no more, and soon once a stop is requested.
  bool read(cv::Mat& bgr, double& taken_s, const std::stop_token& stop = {});

  /// Keeps exposure, white balance and focus as they are.
  void lock();

  double fps() const { return fps_; }  ///< 0: unknown

 private:
  struct Buffer {
    void* at;
    std::size_t bytes;
  };

  bool control(unsigned long request, void* argument);
  bool set_format(const CameraSettings& settings);
  void set_rate(double fps);
  bool start();
  bool wait(const std::stop_token& stop);
  bool convert(std::span<const std::uint8_t> bytes, cv::Mat& bgr);
  void close();

  DriverCalls& calls_;
  int device_ = -1;
  std::vector<Buffer> buffers_;
  double fps_ = 0;
  Libav<AVFrame> raw_{av_frame_alloc()};  ///< what the driver gave
  int stride_bytes_ = 0;
  std::optional<StillDecoder> decoder_;  ///< of JPEGs; none: the pixels are raw
  PixelConverter converter_{PixelConverter::Care::fast};
};

}  // namespace handyar::io
