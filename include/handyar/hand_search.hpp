// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "handyar/color_bins.hpp"
#include "handyar/fingertips.hpp"
#include "handyar/hand_region.hpp"
#include "handyar/hand_shape.hpp"
#include "handyar/outline_search.hpp"
#include "handyar/skin_model.hpp"

namespace handyar {

struct SkinSamples;

struct HandSearchConfig {
  int pixels = 320 * 240;         ///< frames are reduced to about so many
  double min_area_share = 0.008;  ///< of the frame, for a region to be looked at
  double max_deviation = 1.7;     ///< as HandShapeConfig's, but only to be worth a closer look
  int readings_per_frame = 16;    ///< more find a hand sooner and cost more
  int enough_views = 3;           ///< readings and outlines that agree on a hand
  /// How far a hand that one, two, or enough of them show may deviate, times max_deviation: what is
  /// none rarely looks like the same one to several.
  std::array<double, 3> tolerance = {0.85, 1.0, 1.25};
  OutlineSearchConfig outlines;
};

/// Finds a hand without knowing its colour (paper 2.1 and 2.2, but by shape rather than by one
/// threshold). The first look is the paper's: what the skin model takes for skin. Unless that is
/// surely a hand, every reading of the frame's colours proposes regions: the learned hand against
/// this scene's own colours, the prior, the prior against the scene, brightness, redness and
/// blueness, each cut at several thresholds, and the colours of patches of the frame against the
/// whole frame. Where the picture's edges look like a hand's outline, the colours there against
/// those around propose regions too: a hand half in the sun has no colour of its own. The region
/// whose contour is most like a hand wins. What was learned is read in every frame, the other
/// readings and the directions of outlines take turns.
class HandSearch {
 public:
  /// Looks at masks through `stages`, which outlive it; their room must do for the same images.
  explicit HandSearch(MaskStages& stages, const HandSearchConfig& config = {},
                      const HandShapeConfig& shape = {}, const HandShapeModel& model = {});
  ~HandSearch();
  void reserve(int max_pixels, int max_side = 4096);
  void reset() noexcept;

  /// True when a hand-like region was found: `shape` is then in pixels of image(), and mask() holds
  /// its region alone.
  bool find(const BinView& image, const SkinModel& skin, HandShape& shape) noexcept;

  /// For hands of which colours tell nothing.
  OutlineSearch& outlines() noexcept { return outlines_; }

  /// What was found was found by what the skin model takes for skin, not by another reading.
  bool found_by_skin() const noexcept { return found_by_skin_; }

  /// How many times max_deviation the hand that was found may deviate.
  double tolerance() const noexcept {
    return config_.tolerance[agreeing_ >= config_.enough_views ? 2 : agreeing_ > 1 ? 1 : 0];
  }

  /// Where it was found: the image that was searched, which must still be there, or a part of it.
  const BinView& image() const noexcept { return found_image_; }
  const Mask& mask() const noexcept { return found_mask_; }

 private:
  using Channel = std::array<std::int8_t, kBinCount>;
  static constexpr int kMaxLearned = 3;  ///< readings of what was learned
  static constexpr int kMaxAtOnce = 32;  ///< readings: a bit each
  static constexpr int kMaxViews = 20;   ///< of hands in a frame
  struct Reading {
    const Channel* channel = nullptr;
    std::int8_t threshold = 0;
    bool below = false;  ///< what lies below it: a hand may lie on either side
    int patch = -1;      ///< not a channel but the colours of this patch
  };
  bool find_best(const BinView& image, const SkinModel& skin, HandShape& shape) noexcept;
  void read_scene(const BinView& image, const SkinModel& skin) noexcept;
  void list_readings(const BinView& image, const Channel& prior) noexcept;
  void add_levels(const Channel& channel, int levels) noexcept;
  void read_patch(const BinView& image, int patch) noexcept;
  void mark_bins(const BinView& image, std::span<const Reading> readings) noexcept;
  void draw_masks(const BinView& image, int count) noexcept;
  bool try_region(float palm_radius, HandShape& best) noexcept;
  bool take(const HandShape& view, const Eigen::Vector2f& origin, HandShape& best) noexcept;
  bool try_regions(HandShape& best) noexcept;
  bool try_proposal(const BinView& image, const SkinModel& skin, const HandShape& proposal,
                    HandShape& best) noexcept;

  MaskStages& stages_;
  HandSearchConfig config_;
  HandShapeConfig shape_config_;
  HandShapeModel shape_model_;
  Channel known_, scene_;
  ColorHistogram scene_colors_;      ///< of the frame, later of what surrounds a proposal
  std::vector<ColorBin> seen_bins_;  ///< that the scene has
  std::size_t seen_count_ = 0;
  std::vector<float> coarse_, patch_, patch_smooth_;
  std::array<bool, 4096> in_patch_{};
  std::array<Reading, 128> readings_;
  int reading_count_ = 0;
  std::array<HandShape, kMaxViews> views_;  ///< by this frame's readings and outlines, in its bins
  int view_count_ = 0;
  int agreeing_ = 0;  ///< of them with what was found
  bool found_by_skin_ = false;
  int next_ = 0;                      ///< whose turn it is
  std::vector<std::uint32_t> marks_;  ///< of each bin, a bit for each of this frame's readings
  std::vector<Mask> masks_;
  Mask scratch_mask_, found_mask_;
  BinView found_image_;
  OutlineSearch outlines_;
  ColorHistogram hand_colors_;  ///< along the fingers of a proposal
  SkinModel::Ratios proposed_;  ///< by its colours
  std::unique_ptr<SkinSamples> samples_;
  ExpectedRegion expectation_;
  ExpectedRegion anywhere_{.ratios = {ExpectedRegion::kInside}};
};

}  // namespace handyar
