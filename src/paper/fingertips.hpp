// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "handyar/paper/tracker.hpp"
#include "paper/hand_region.hpp"

namespace handyar::paper {

/// A fingertip of a contour, mask pixels.
struct Fingertip {
  Eigen::Vector2f at = Eigen::Vector2f::Zero();
  int sample = 0;    ///< on the resampled contour
  float cosine = 0;  ///< of the contour's turn there, mean over the scales; 1 is a needle
};

/// Fingertips of a hand region (paper 2.2): the contour's convex points of high curvature at
/// several scales, then the ends of ellipses fitted around them.
class FingertipFinder {
 public:
  static constexpr int kMostTips = 12;

  explicit FingertipFinder(const Config& config) : config_(config) {}
  void reserve(int mask_pixels);

  /// In the contour's order, clockwise on the screen. Valid until the next call.
  std::span<const Fingertip> find(const HandRegion& region) noexcept;

 private:
  bool trace(const Mask& mask, Eigen::Vector2i first) noexcept;
  void resample(float spacing) noexcept;
  float cosine_at(int sample, int arm, bool& convex) const noexcept;
  void add_tip(int sample, float cosine) noexcept;
  void fit_ellipse(Fingertip& tip, const Eigen::Vector2f& palm, float width) const noexcept;

  const Config& config_;
  std::vector<Eigen::Vector2f> contour_, samples_;
  std::vector<float> cosines_;
  float spacing_ = 1;
  std::array<Fingertip, kMostTips> tips_;
  int count_ = 0;
};

}  // namespace handyar::paper
