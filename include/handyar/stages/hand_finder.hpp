// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <optional>
#include <span>

#include "handyar/hand_model.hpp"
#include "handyar/image_view.hpp"

namespace handyar {

/// A part of a frame, which may reach beyond it; pixels, from the top-left pixel's centre.
struct FinderRegion {
  Eigen::Vector2f centre_px = Eigen::Vector2f::Zero();
  float width_px = 0;            ///< its height is three quarters of that
  Eigen::Vector2f up = {0, -1};  ///< where its top is: a unit vector in the frame

  /// Where a place in it is in the frame; its width is `across`, (0, 0) its top-left corner.
  Eigen::Vector2f to_frame(const Eigen::Vector2f& place, float across) const noexcept {
    const Eigen::Vector2f off = (place / across - Eigen::Vector2f(0.5f, 0.375f)) * width_px;
    return centre_px + off.x() * Eigen::Vector2f(-up.y(), up.x()) - off.y() * up;
  }
};

/// Where a hand is in a frame.
struct HandPlace {
  Eigen::Vector2f palm_px = Eigen::Vector2f::Zero();
  std::array<Eigen::Vector2f, kFingerCount> tips_px{};

  /// Distance from thumb tip to little fingertip, pixels.
  float span_px() const noexcept { return (tips_px[0] - tips_px[4]).norm(); }
  /// Distance from the palm to the farthest fingertip, pixels.
  float reach_px() const noexcept;
  /// Whether each fingertip is about where the other's is.
  bool same_tips(const HandPlace& other) const noexcept;
  /// A part of the frame with the hand in its middle, upright.
  FinderRegion region(float width_px) const noexcept;
};

/// Where an open hand may be.
struct HandCandidate : HandPlace {
  Layout layout = Layout::thumb_right;
  float log_odds = 0;                                    ///< of an open hand there against none
  float palm_log_odds = 0;                               ///< of its palm in view against its back
  std::array<Eigen::Vector2f, kFingerCount> roots_px{};  ///< of the fingers, in the hand

  /// Standard deviation of a fingertip along each axis, as it is among training pictures.
  float tip_sigma_px() const noexcept;
};

/// Finds open hands by a small convolutional network (tools/finder tells what it was trained on).
/// It looks at 160 x 120 samples of a frame, so a hand is found that is 17 to 110 of them wide.
class HandFinder {
 public:
  HandFinder();
  ~HandFinder();
  HandFinder(HandFinder&&) noexcept;
  HandFinder& operator=(HandFinder&&) noexcept;

  /// Searches a frame: where a hand was lost, if one was, then the whole or, for smaller hands, one
  /// of its parts, in turn from frame to frame, and once more around the likeliest hand for its
  /// fingertips. The likeliest candidate first. Valid until the next call.
  std::span<const HandCandidate> search(const ImageView& frame,
                                        const std::optional<FinderRegion>& lost_in = {}) noexcept;

  /// One look at a part of a frame.
  std::span<const HandCandidate> look(const ImageView& frame, const FinderRegion& region) noexcept;

  /// As newly made.
  void reset() noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace handyar
