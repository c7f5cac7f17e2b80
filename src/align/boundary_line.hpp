// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "align/hand_view.hpp"
#include "align/outline_colors.hpp"
#include "align/silhouette.hpp"
#include "image/pixel_reader.hpp"
#include "vectorised.hpp"

namespace handyar {

/// No line, and no point, tells more: it may be wrong altogether. Nats.
inline constexpr float kMostEvidence = 3.0f;
/// Neighbouring ones see the same light, the same wrong figure: so much of one's say is its own.
inline constexpr double kLineWeight = 0.15;

/// Where along a line the boundary between hand and background lies.
struct Boundary {
  float mean_px = 0, sigma_px = 1;  ///< from the line's place, outwards
  float log_ratio = 0;  ///< for a boundary at the line's place against one anywhere near
};

/// A line across the figure's outline, along its normal.
class BoundaryLine {
 public:
  static constexpr int kHalf = 7;  ///< segments on each side

  BoundaryLine(const PixelReader& reader, const HandView& view, const OutlinePlace& place,
               float segment_px, float inside_px, float outside_px) noexcept;

  bool inside_frame() const noexcept { return reader_.covers(from_.x(), from_.y()); }
  Eigen::Vector2f frame_px() const noexcept { return from_; }
  Eigen::Vector2f frame_normal() const noexcept { return step_; }

  /// Where the pixel `r_px` (of the view) outside of the outline is; empty beyond the frame.
  HANDYAR_ALWAYS_INLINE std::optional<Eigen::Vector2i> pixel(float r_px) const noexcept {
    const float x = from_.x() + r_px * step_.x(), y = from_.y() + r_px * step_.y();
    if (!reader_.covers(x, y)) return std::nullopt;
    return Eigen::Vector2i(reader_.nearest_x(x), reader_.nearest_y(y));
  }

  /// The boundary by the colours on both sides and, where `edges`, by steps in luma.
  Boundary find(const OutlineColors& colors, int part, bool edges) const noexcept;
  /// That of two fingers: as a rule it is darker than both.
  Boundary find_furrow(const OutlineColors& colors, int part) const noexcept;

 private:
  static constexpr int kSegments = 2 * kHalf;
  static constexpr int kPlaces = kSegments - 1;  ///< where the boundary may lie: between segments
  static_assert(2 * kSegments <= PixelGroup::kMost);
  using Places = std::array<float, 16>;  ///< kPlaces numbers, in whole vectors

  /// Mean log ratio of hand against background, and luma, from inside to outside.
  struct Segments {
    std::array<float, kSegments> ratio{}, luma{};
    std::array<int, kSegments> reads{};  ///< 0: not seen, ratio 0
  };

  int read(Segments& segments, PixelGroup& group) const noexcept;
  Segments segments(const OutlineColors& colors, int part) const noexcept;
  /// Of how likely it is at each of the places, that so many are asked about.
  Boundary boundary(const Places& p, int seen) const noexcept;

  const PixelReader& reader_;
  Eigen::Vector2f from_, step_;  ///< in the frame: the place, and one pixel of the view outwards
  float segment_px_, inside_px_, outside_px_;
};

}  // namespace handyar
