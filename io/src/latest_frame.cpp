// SPDX-License-Identifier: MIT
#include "handyar/io/latest_frame.hpp"

#include <chrono>
#include <utility>

namespace handyar::io {
namespace {

constexpr std::chrono::milliseconds kAsked{100};

}  // namespace

LatestFrame::LatestFrame(Grab grab)
    : grab_(std::move(grab)), thread_([this](const std::stop_token& stop) { run(stop); }) {}

void LatestFrame::run(const std::stop_token& stop) {
  Frame frame;
  std::int64_t index = 0;
  bool more = true;
  while (more) {
    std::exception_ptr fault;
    try {
      more = grab_(frame, stop);
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
    more = more && !stop.stop_requested();
    ended_ = !more;
    fault_ = fault;
    changed_.notify_one();
  }
}

bool LatestFrame::read(Frame& frame, const std::function<bool()>& wait_on) {
  std::unique_lock lock(mutex_);
  while (!changed_.wait_for(lock, kAsked, [this] { return fresh_ || ended_; })) {
    lock.unlock();  // what is asked may take its time
    if (wait_on && !wait_on()) return false;
    lock.lock();
  }
  if (fresh_) {
    fresh_ = false;
    std::swap(frame, latest_);
    return true;
  }
  if (fault_) std::rethrow_exception(fault_);
  return false;
}

}  // namespace handyar::io
