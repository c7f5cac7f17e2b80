// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "handyar/color_bins.hpp"
#include "handyar/fingertips.hpp"
#include "handyar/hand_region.hpp"
#include "handyar/hand_shape.hpp"
#include "handyar/skin_model.hpp"

namespace handyar {

struct HandSearchConfig {
  int longer_side = 320;          ///< frames are reduced to about this many pixels
  double min_area_share = 0.008;  ///< of the frame, for a region to be looked at
};

/// Finds a hand without knowing its colour: several readings of the frame's colours (the skin
/// model, the prior, the prior against this scene's own colours, brightness, redness), each cut at
/// several thresholds, propose regions; the one whose contour is most like a hand wins.
class HandSearch {
 public:
  HandSearch(const HandSearchConfig& config, const FingertipConfig& fingertips,
             const HandShapeConfig& shape);
  void reserve(int max_pixels);

  /// True when a hand-like region was found. `shape` is then in pixels of `image`, and
  /// region().mask() holds its region alone.
  bool find(const BinImage& image, ColorSpace space, const SkinModel& skin,
            HandShape& shape) noexcept;

  const RegionFinder& region() const noexcept { return region_; }
  int winner() const noexcept { return winner_; }

 private:
  using Channel = std::array<std::int8_t, kBinCount>;
  struct Reading {
    int channel;
    int threshold;
  };
  void read_scene(const BinImage& image, const SkinModel& skin) noexcept;
  void add_levels(int channel, int levels) noexcept;
  bool try_reading(const BinImage& image, const Reading& reading, HandShape& best,
                   Component& best_component) noexcept;

  HandSearchConfig config_;
  HandShapeConfig shape_config_;
  RegionFinder region_;
  Contour contour_;
  CurvatureFinder curvature_;
  std::vector<Channel> channels_;
  std::vector<float> scene_, scratch_, smooth_;
  std::array<Reading, 64> readings_;
  int reading_count_ = 0;
  int winner_ = -1;
  ColorSpace space_ = ColorSpace::rgb;
  bool fixed_channels_ready_ = false;
};

}  // namespace handyar
