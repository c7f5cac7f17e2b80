// SPDX-License-Identifier: MIT
#include "handyar/io/latest_frame.hpp"

#include <utility>

namespace handyar::io {

LatestFrame::LatestFrame(Grab grab) : grab_(std::move(grab)), thread_([this] { run(); }) {}

LatestFrame::~LatestFrame() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  thread_.join();
}

void LatestFrame::run() {
  Frame frame;
  std::int64_t index = 0;
  bool more = true;
  while (more) {
    std::exception_ptr fault;
    try {
      more = grab_(frame);
    } catch (...) {
      fault = std::current_exception();
      more = false;
    }
    const std::lock_guard lock(mutex_);
    if (more) {
      frame.index = index++;
      std::swap(frame, latest_);
      fresh_ = true;
    }
    more = more && !stopping_;
    ended_ = !more;
    fault_ = fault;
    changed_.notify_one();
  }
}

bool LatestFrame::read(Frame& frame) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return fresh_ || ended_; });
  if (fresh_) {
    fresh_ = false;
    std::swap(frame, latest_);
    return true;
  }
  if (fault_) std::rethrow_exception(fault_);
  return false;
}

}  // namespace handyar::io
