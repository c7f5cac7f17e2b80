// SPDX-License-Identifier: MIT
// A camera's driver that is none: it answers the system calls.
#pragma once

#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <deque>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "driver_calls.hpp"
#include "io_files.hpp"

namespace handyar::io {

using Bytes = std::vector<std::uint8_t>;

inline constexpr const char* kDevice = "/dev/video0";
inline constexpr int kWidth_px = 320, kHeight_px = 240;
inline constexpr double kStart_s = 5000;

struct Shot {
  Bytes bytes;
  double taken_s = kStart_s;
  bool faulty = false;  ///< the driver says so
};

class FakeDriver : public DriverCalls {
 public:
  std::vector<std::uint32_t> formats = {V4L2_PIX_FMT_YUYV};
  unsigned width_px = kWidth_px;
  unsigned padding_bytes = 0;  ///< behind every row
  std::size_t buffer_bytes = 600'000;
  bool is_camera = true, busy = false;
  std::deque<Shot> shots;  ///< what it sees; then it is unplugged
  bool stalls = false;     ///< instead of that, nothing comes any more
  int pause_ms = 0;        ///< before every picture

  std::uint32_t chosen = 0;
  double rate = 0;
  std::map<std::uint32_t, int> controls;
  int open_devices = 0, mapped = 0, polls = 0;

  int open(const char* path) override {
    errno = ENOENT;
    if (std::string(path) != kDevice) return -1;
    ++open_devices;
    return 7;
  }
  void close(int device) override { open_devices -= device == 7; }
  void* map(int, std::size_t, std::int64_t offset) override {
    ++mapped;
    return buffers_[static_cast<std::size_t>(offset) / kPage].data();
  }
  void unmap(void*, std::size_t) override { --mapped; }
  int poll(int, int timeout_ms) override {
    EXPECT_GT(timeout_ms, 0);
    ++polls;
    std::this_thread::sleep_for(std::chrono::milliseconds(pause_ms));
    return shots.empty() && stalls ? 0 : 1;
  }
  int control(int device, unsigned long request, void* argument) override {
    errno = device == 7 ? answer(request, argument) : EBADF;
    return errno == 0 ? 0 : -1;
  }

 private:
  static constexpr std::size_t kPage = 4096;

  int answer(unsigned long request, void* argument) {
    switch (request) {
      case VIDIOC_QUERYCAP:
        static_cast<v4l2_capability*>(argument)->capabilities =
            V4L2_CAP_STREAMING | (is_camera ? V4L2_CAP_VIDEO_CAPTURE : V4L2_CAP_VIDEO_OUTPUT);
        return 0;
      case VIDIOC_ENUM_FMT:
        return describe(*static_cast<v4l2_fmtdesc*>(argument));
      case VIDIOC_S_FMT:
        return busy ? EBUSY : set(static_cast<v4l2_format*>(argument)->fmt.pix);
      case VIDIOC_S_PARM:
      case VIDIOC_G_PARM:
        return set(static_cast<v4l2_streamparm*>(argument)->parm.capture.timeperframe);
      case VIDIOC_S_CTRL:
        controls[static_cast<v4l2_control*>(argument)->id] =
            static_cast<v4l2_control*>(argument)->value;
        return 0;
      case VIDIOC_REQBUFS:
        static_cast<v4l2_requestbuffers*>(argument)->count = 3;
        for (int i = 0; i < 3; ++i) buffers_.emplace_back(buffer_bytes);
        return 0;
      case VIDIOC_QUERYBUF:
        static_cast<v4l2_buffer*>(argument)->length = static_cast<unsigned>(buffer_bytes);
        static_cast<v4l2_buffer*>(argument)->m.offset =
            static_cast<v4l2_buffer*>(argument)->index * kPage;
        return 0;
      case VIDIOC_QBUF:
        queue_.push_back(static_cast<v4l2_buffer*>(argument)->index);
        return 0;
      case VIDIOC_DQBUF:
        return fill(*static_cast<v4l2_buffer*>(argument));
      case VIDIOC_STREAMON:
      case VIDIOC_STREAMOFF:
        return 0;
      default:
        return ENOTTY;
    }
  }

  int describe(v4l2_fmtdesc& format) const {
    if (format.index >= formats.size()) return EINVAL;
    format.pixelformat = formats[format.index];
    return 0;
  }

  // It has one size.
  int set(v4l2_pix_format& format) {
    chosen = format.pixelformat;
    format.width = width_px;
    format.height = kHeight_px;
    const auto row_bytes = [&]() -> unsigned {
      switch (chosen) {
        case V4L2_PIX_FMT_YUYV:
        case V4L2_PIX_FMT_UYVY:
          return 2 * kWidth_px;
        case V4L2_PIX_FMT_BGR24:
        case V4L2_PIX_FMT_RGB24:
          return 3 * kWidth_px;
        default:
          return kWidth_px;
      }
    };
    format.bytesperline = chosen == V4L2_PIX_FMT_MJPEG ? 0 : row_bytes() + padding_bytes;
    return 0;
  }

  int set(v4l2_fract& step_s) {
    if (step_s.numerator > 0) rate = double(step_s.denominator) / step_s.numerator;
    return 0;
  }

  int fill(v4l2_buffer& buffer) {
    if (shots.empty()) return ENODEV;
    if (queue_.empty()) return EAGAIN;
    const Shot shot = std::move(shots.front());
    shots.pop_front();
    buffer.index = queue_.front();
    queue_.pop_front();
    std::copy(shot.bytes.begin(), shot.bytes.end(), buffers_[buffer.index].data());
    buffer.bytesused = static_cast<std::uint32_t>(shot.bytes.size());
    const auto us = static_cast<long>(std::llround(shot.taken_s * 1e6));
    buffer.timestamp = {us / 1'000'000, us % 1'000'000};
    buffer.flags = shot.faulty ? V4L2_BUF_FLAG_ERROR : 0;
    return 0;
  }

  std::deque<Guarded> buffers_;
  std::deque<std::uint32_t> queue_;
};

}  // namespace handyar::io
