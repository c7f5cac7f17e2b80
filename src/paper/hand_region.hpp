// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "handyar/image_view.hpp"
#include "paper/skin_model.hpp"

namespace handyar::paper {

/// A binary picture with a margin of one pixel, which is never set.
struct Mask {
  int width = 0, height = 0;
  std::vector<std::uint8_t> pixels;  ///< 255 or 0, (width + 2) a row

  void resize(int new_width, int new_height);
  int at_index(int u, int v) const { return (v + 1) * (width + 2) + u + 1; }
  bool at(int u, int v) const { return pixels[at_index(u, v)] != 0; }
};

/// The hand in a frame (paper 2.1): the largest connected region of skin, and in it the palm, the
/// largest disc.
class HandRegion {
 public:
  /// Room for frames of this size, each `step`-th pixel of them.
  void resize(int width_px, int height_px, int step);

  /// False when there is no region large enough to be a hand.
  bool find(const ImageView& frame, const SkinModel& skin) noexcept;

  const Mask& mask() const { return mask_; }
  Eigen::Vector2f palm() const { return palm_; }      ///< mask pixels
  float palm_radius() const { return palm_radius_; }  ///< mask pixels
  /// Leftmost pixel of the region's uppermost row.
  Eigen::Vector2i first() const { return first_; }

  /// Colours well inside the region and well outside of it, for learning.
  const std::vector<ColorBin>& hand_colors() const { return hand_; }
  const std::vector<ColorBin>& background_colors() const { return background_; }
  void collect_colors() noexcept;

 private:
  void classify(const ImageView& frame, const SkinModel& skin) noexcept;
  bool keep_largest() noexcept;
  void measure_distances() noexcept;

  int step_ = 1;
  Mask mask_;
  std::vector<ColorBin> bins_, hand_, background_;
  std::vector<float> ratios_;
  std::vector<std::int32_t> labels_, stack_;
  std::vector<std::int16_t> distance_;  ///< thirds of a pixel
  Eigen::Vector2f palm_ = Eigen::Vector2f::Zero();
  Eigen::Vector2i first_ = Eigen::Vector2i::Zero();
  float palm_radius_ = 0;
};

}  // namespace handyar::paper
