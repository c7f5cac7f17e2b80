// SPDX-License-Identifier: MIT
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <variant>

#include "handyar/world/world_tracker.hpp"
#include "look.hpp"
#include "picture.hpp"

namespace handyar::world {

/// What was made of a picture in which the world was looked for.
struct Recognised {
  Picture picture;
  double time_s;
  std::optional<Seen> seen;
};

using MapPointer = std::shared_ptr<const WorldMap>;

/// Does what takes longer than a frame, one thing at a time: within start(), or on a thread beside
/// it.
class Worker {
 public:
  using Done = std::variant<MapPointer, Recognised>;

  explicit Worker(Mapping mapping) {
    if (mapping == Mapping::background)
      thread_ = std::jthread([this](std::stop_token stop) { run(stop); });
  }

  /// Whether something was started and not taken yet.
  bool busy() const noexcept { return busy_; }

  /// Only when not busy.
  void start(std::function<Done()> work) {
    busy_ = true;
    if (!thread_.joinable()) {
      done_ = work();
      return;
    }
    const std::scoped_lock lock(mutex_);
    work_ = std::move(work);
    changed_.notify_one();
  }

  /// What was made, once, when it is there.
  std::optional<Done> take() {
    if (!busy_) return std::nullopt;
    const std::scoped_lock lock(mutex_);
    busy_ = !done_;
    return std::exchange(done_, std::nullopt);
  }

 private:
  void run(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    while (changed_.wait(lock, stop, [&] { return work_ != nullptr; })) {
      const std::function<Done()> work = std::exchange(work_, nullptr);
      lock.unlock();
      Done done = work();
      lock.lock();
      done_ = std::move(done);
    }
  }

  bool busy_ = false;  // known to the frame path alone
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::function<Done()> work_;
  std::optional<Done> done_;
  std::jthread thread_;  // last: it ends before what it uses
};

}  // namespace handyar::world
