// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <variant>

#include "handyar/paper/tracker.hpp"
#include "handyar/tracker.hpp"

namespace handyar {

enum class Method : std::uint8_t {
  figure,  ///< HandTracker
  paper    ///< paper::Tracker
};

/// Either method behind one door, for programs that let the user choose.
class AnyTracker {
 public:
  AnyTracker(HandTracker tracker) : tracker_(std::move(tracker)) {}
  AnyTracker(paper::Tracker tracker) : tracker_(std::move(tracker)) {}

  TrackResult process(const ImageView& frame, double time_s) noexcept {
    return std::visit([&](auto& t) { return t.process(frame, time_s); }, tracker_);
  }
  std::optional<FilteredPose> predict(double time_s) const noexcept {
    return std::visit([&](const auto& t) { return t.predict(time_s); }, tracker_);
  }
  void reset() noexcept {
    std::visit([](auto& t) { t.reset(); }, tracker_);
  }
  HandMask mask() const noexcept {
    return std::visit([](const auto& t) { return t.mask(); }, tracker_);
  }
  HandModel hand() const noexcept {
    return std::visit([](const auto& t) { return t.hand(); }, tracker_);
  }
  /// What the figure method saw in the last frame; null for the paper's.
  const FrameEvidence* evidence() const noexcept {
    const HandTracker* figure = std::get_if<HandTracker>(&tracker_);
    return figure != nullptr ? &figure->evidence() : nullptr;
  }

  /// The figure method's tracker. Throws std::bad_variant_access for the paper's.
  HandTracker& figure() { return std::get<HandTracker>(tracker_); }

 private:
  std::variant<HandTracker, paper::Tracker> tracker_;
};

}  // namespace handyar
