// SPDX-License-Identifier: MIT
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>

#include "handyar/io/frame_source.hpp"

namespace handyar::io {

/// Takes frames from a camera on a thread of its own and keeps only the newest, so that a slow
/// reader sees what is, not what was: drivers queue several frames.
class LatestFrame {
 public:
  /// Blocks until the next frame, fills bgr and time_s; false when the camera gives no more, and
  /// soon once a stop is requested.
  using Grab = std::function<bool(Frame&, const std::stop_token&)>;

  explicit LatestFrame(Grab grab);

  /// The newest frame, once; waits for one when the last was already given, and asks `wait_on` (if
  /// any) ten times a second whether to. False when it says no, or the camera gives no more.
  /// Rethrows what `grab` threw.
  bool read(Frame& frame, const std::function<bool()>& wait_on = {});

 private:
  void run(const std::stop_token& stop);

  Grab grab_;
  std::mutex mutex_;
  std::condition_variable changed_;
  Frame latest_;
  bool fresh_ = false, ended_ = false;
  std::exception_ptr fault_;
  std::jthread thread_;  // last: it ends before what it uses goes
};

}  // namespace handyar::io
