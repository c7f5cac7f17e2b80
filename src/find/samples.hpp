// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <span>

#include "handyar/image_view.hpp"

namespace handyar {

/// A grid over a part of a frame, which may reach beyond it, as a network sees it; pixels, from the
/// top-left pixel's centre.
struct SampleGrid {
  int width, height;
  Eigen::Vector2f first_px;           ///< the middle of the first sample
  Eigen::Vector2f right_px, down_px;  ///< from one to the next
};

/// Red, green and blue of each sample, 0 to 255, row by row: means over its pixels, grey beyond the
/// frame. All machines give the same bits.
void take_samples(const ImageView& frame, const SampleGrid& grid, std::span<float> rgb) noexcept;

}  // namespace handyar
