// SPDX-License-Identifier: MIT
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

#include "handyar/io/frame_source.hpp"

namespace handyar::io {

/// Takes frames from a camera on a thread of its own and keeps only the newest, so that a slow
/// reader sees what is, not what was: drivers queue several frames.
class LatestFrame {
 public:
  /// Blocks until the next frame, fills bgr and time_s; false when the camera gives no more.
  using Grab = std::function<bool(Frame&)>;

  explicit LatestFrame(Grab grab);
  ~LatestFrame();
  LatestFrame(const LatestFrame&) = delete;
  LatestFrame& operator=(const LatestFrame&) = delete;

  /// The newest frame, once; waits for one when the last was already given. False when the camera
  /// gives no more. Rethrows what `grab` threw.
  bool read(Frame& frame);

 private:
  void run();

  Grab grab_;
  std::mutex mutex_;
  std::condition_variable changed_;
  Frame latest_;
  bool fresh_ = false, ended_ = false, stopping_ = false;
  std::exception_ptr fault_;
  std::thread thread_;
};

}  // namespace handyar::io
