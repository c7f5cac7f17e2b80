// SPDX-License-Identifier: MIT
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "mapping.hpp"

namespace handyar::world {

/// Extends maps, one at a time: within start(), or on a thread beside it.
class MapWorker {
 public:
  using Map = std::shared_ptr<const WorldMap>;

  explicit MapWorker(Mapping mapping) {
    if (mapping == Mapping::background)
      thread_ = std::jthread([this](std::stop_token stop) { run(stop); });
  }

  /// Whether a map was started and not taken yet.
  bool busy() const noexcept { return busy_; }

  /// Only when not busy.
  void start(Map map, NewView view) {
    busy_ = true;
    if (!thread_.joinable()) {
      done_ = std::make_shared<const WorldMap>(extended(*map, view));
      return;
    }
    const std::scoped_lock lock(mutex_);
    job_.emplace(std::move(map), std::move(view));
    changed_.notify_one();
  }

  /// The extended map, once, when it is there.
  Map take() {
    if (!busy_) return nullptr;
    const std::scoped_lock lock(mutex_);
    busy_ = done_ == nullptr;
    return std::exchange(done_, nullptr);
  }

 private:
  void run(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    while (changed_.wait(lock, stop, [&] { return job_.has_value(); })) {
      const auto [map, view] = *std::exchange(job_, std::nullopt);
      lock.unlock();
      auto done = std::make_shared<const WorldMap>(extended(*map, view));
      lock.lock();
      done_ = std::move(done);
    }
  }

  bool busy_ = false;  // known to the frame path alone
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<std::pair<Map, NewView>> job_;
  Map done_;
  std::jthread thread_;  // last: it ends before what it uses
};

}  // namespace handyar::world
