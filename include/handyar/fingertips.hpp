// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "handyar/contour.hpp"

namespace handyar {

/// How a fingertip's place is measured (the paper's Table 2 compares them).
enum class FingertipMethod : std::uint8_t {
  curvature,  ///< the contour point of the sharpest turn
  ellipse     ///< the end of an ellipse fitted around it
};

struct FingertipConfig {
  FingertipMethod method = FingertipMethod::ellipse;
  /// Cosine between the two arms of the contour at a tip, above which it counts (paper: 0.5).
  double min_cosine = 0.25;
  /// Shortest and longest arm in palm radii; a finger is about 0.42 palm radii wide.
  double min_arm = 0.5;
  double max_arm = 1.1;
  /// By which share of a finger's width tips and valleys move from frame to frame when nothing
  /// does. The sharpest turn is one of the contour's samples, which lie apart.
  double ellipse_noise = 0.018, curvature_noise = 0.060, valley_noise = 0.025;
  double axis_noise = 0.010;  ///< of each place on a finger's axis, across it; the same unit
  double outline_noise = 3;   ///< times as far where an outline tells, which is rougher
};

/// A place where the contour turns sharply outwards, as at a fingertip.
struct Extremum {
  int sample = 0;                                ///< index into the resampled contour
  Eigen::Vector2f at = Eigen::Vector2f::Zero();  ///< mask pixels
  float cosine = 0;                              ///< mean over the scales; 1 = a needle
};

/// Contour curvature at several scales (paper 2.2, equation 1) and its extrema.
class CurvatureFinder {
 public:
  static constexpr int kMaxSamples = 1024;
  static constexpr int kMaxTips = 16;

  explicit CurvatureFinder(const FingertipConfig& config = {});

  /// Resamples the contour to the palm's size and finds its convex extrema in contour order.
  /// `palm_radius` is in mask pixels.
  void find(const Contour& contour, float palm_radius) noexcept;

  std::span<const Extremum> tips() const noexcept {
    return {tips_.data(), std::size_t(tip_count_)};
  }
  std::span<const Eigen::Vector2f> samples() const noexcept {
    return {samples_.data(), std::size_t(sample_count_)};
  }
  /// Distance between neighbouring samples in mask pixels.
  float spacing() const noexcept { return spacing_; }

  /// The deepest point of the contour between two samples (clockwise from a to b): the sample that
  /// is farthest on the inner side of the line a-b, and that distance (negative: none is inside).
  int valley(int a, int b, float* depth) const noexcept;

 private:
  FingertipConfig config_;
  static constexpr int kMaxArm = kMaxSamples / 4;
  std::vector<Eigen::Vector2f> samples_;
  std::vector<float> x_, y_;  ///< of the samples, wrapped around by kMaxArm at both ends
  std::vector<float> convexity_;
  int sample_count_ = 0;
  float spacing_ = 1;
  std::array<Extremum, kMaxTips> tips_;
  int tip_count_ = 0;
};

/// The stages from a mask to its fingertips. They keep nothing from one mask to the next: whoever
/// looks at masks one after the other shares their room.
struct MaskStages {
  RegionFinder region;
  Contour contour;
  CurvatureFinder curvature;

  explicit MaskStages(const FingertipConfig& config = {}) : curvature(config) {}
  /// Room for masks of up to `max_pixels` pixels in frames of up to `max_side` pixels a side.
  void reserve(int max_pixels, int max_side = 4096);
};

/// Measures the tip near contour arc length `arc` of a finger that begins at `base` and is about
/// `width` wide, all in mask pixels: the end of a least-squares ellipse around it (paper 2.2).
Eigen::Vector2f measure_tip(const Contour& contour, float arc, const Eigen::Vector2f& base,
                            float width, FingertipMethod method) noexcept;

/// Between which its sides are straight, as shares of the way from the tip to the nearer valley.
constexpr double kAxisEnd = 0.25, kAxisRoot = 0.8;

/// Two places on the axis of a finger, the line in the middle between its sides, in mask pixels.
struct MeasuredAxis {
  Eigen::Vector2f end, root;  ///< near the fingertip and near the valleys
};

/// Measures the axis of the finger whose tip is at contour arc length `arc`, that begins at `base`
/// between `valleys` (one or two) and is about `width` wide, all in mask pixels: straight lines
/// fitted to both sides where the finger is neither round yet nor part of the hand any more. What
/// moves both sides outwards alike, as light and a blurred picture do, leaves it where it is. False
/// when the finger is too short or its sides are no finger's.
bool measure_axis(const Contour& contour, float arc, const Eigen::Vector2f& base,
                  std::span<const Eigen::Vector2f> valleys, float width,
                  MeasuredAxis& out) noexcept;

/// Measures the valley near `near` between two fingers about `width` mask pixels wide: on the full
/// contour, the deepest point behind the line through both tips of a parabola fitted to the
/// boundary about half a width each way; `near` itself where the boundary does not turn there.
Eigen::Vector2f measure_valley(const Contour& contour, const Eigen::Vector2f& near,
                               const Eigen::Vector2f& tip, const Eigen::Vector2f& next_tip,
                               float width) noexcept;

/// Ellipse fitted by least squares to points (Halir and Flusser 1998); false when they form none.
struct Ellipse {
  Eigen::Vector2f center, axis;  ///< `axis`: unit direction of the major axis
  float major = 0, minor = 0;    ///< half lengths

  /// Where a finger from `base` on ends that has this ellipse at its end: along the major axis
  /// (paper 2.2), as far as there is one. A blunt or foreshortened finger's is about as wide as
  /// long, its axis points anywhere, and the finger's own direction counts.
  Eigen::Vector2f end_away_from(const Eigen::Vector2f& base) const noexcept;
};
bool fit_ellipse(std::span<const Eigen::Vector2f> points, Ellipse& out) noexcept;

/// The ellipse that measure_tip() fits to the end of a finger; false when there is none.
bool fit_tip_ellipse(const Contour& contour, float arc, float width, Ellipse& out) noexcept;

}  // namespace handyar
