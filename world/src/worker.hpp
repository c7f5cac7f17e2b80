// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <future>
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
  bool busy() const noexcept { return done_.valid(); }

  /// Only when not busy.
  void start(std::function<Done()> work) {
    std::packaged_task<Done()> task(std::move(work));
    done_ = task.get_future();
    if (!thread_.joinable()) return task();
    const std::scoped_lock lock(mutex_);
    task_ = std::move(task);
    changed_.notify_one();
  }

  /// What was made, once, when it is there; throws what the work threw.
  std::optional<Done> take() {
    if (!busy() || done_.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
      return std::nullopt;
    return done_.get();
  }

 private:
  void run(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    while (changed_.wait(lock, stop, [&] { return task_.valid(); })) {
      std::packaged_task<Done()> task = std::move(task_);
      lock.unlock();
      task();
      lock.lock();
    }
  }

  std::future<Done> done_;  // known to the frame path alone
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::packaged_task<Done()> task_;
  std::jthread thread_;  // last: it ends before what it uses
};

}  // namespace handyar::world
