// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "handyar/color_bins.hpp"

namespace handyar {

/// The colours of one hand or glove: a distribution over RGB bins, whatever frames it was learned
/// from. Takes the place of the general skin prior.
struct SkinColors {
  struct Entry {
    ColorBin rgb_bin = 0;
    float share = 0;
  };
  std::vector<Entry> entries;  ///< each bin once; shares are positive and add up to one

  bool empty() const noexcept { return entries.empty(); }
};

struct SkinModelConfig {
  int learn_frames = 5;  ///< frames over which learned histograms are accumulated (paper: n)
  /// Weight of the prior against what was learned. Less for the hand than for the background:
  /// colours that were seen on neither are rather background.
  double hand_prior_weight = 0.03;
  double background_prior_weight = 0.2;
  SkinColors personal;  ///< this hand's colours, where known; empty: skin in general
};

/// Adaptive skin model (paper 2.1): for each colour bin the log likelihood ratio of hand against
/// background, in eighths of a nat; above zero: rather hand.
///
/// Prior: the mixtures of Jones and Rehg, or the person's own colours for the hand. Learned:
/// histograms of the verified hand and of what surrounds it. All are probabilities over the same
/// bins, so that they can be mixed.
class SkinModel {
 public:
  using Ratios = std::array<std::int8_t, kBinCount>;

  explicit SkinModel(const SkinModelConfig& config = {});

  /// Back to the prior, for frames of the given colour space.
  void reset(ColorSpace space) noexcept;

  /// Adds a frame in which the hand was verified: bins of pixels that surely show it, and of pixels
  /// around it that surely do not.
  void learn(std::span<const ColorBin> hand, std::span<const ColorBin> background) noexcept;

  bool has_learned() const noexcept { return learned_frames_ > 0; }
  /// Colours of the hand over the last frames; empty before anything was learned. Takes memory.
  SkinColors learned_colors() const;

  const Ratios& ratios() const noexcept { return ratios_; }

  /// -log probability in eighths of a nat of each bin under the prior alone, bin by bin.
  std::span<const std::uint8_t> prior_skin() const noexcept { return prior_skin_; }
  std::span<const std::uint8_t> prior_other() const noexcept { return prior_other_; }

 private:
  struct Histogram {
    std::vector<float> count, smooth;
    float total = 0;
  };
  void accumulate(Histogram& histogram, std::span<const ColorBin> bins) noexcept;
  void rebuild() noexcept;

  SkinModelConfig config_;
  ColorSpace space_ = ColorSpace::rgb;
  std::vector<std::uint8_t> personal_;  // by RGB bin, as the prior's table; empty: none
  std::vector<std::uint8_t> prior_skin_, prior_other_;
  std::vector<float> prior_skin_probability_, prior_other_probability_;
  Histogram hand_, background_;
  std::vector<float> scratch_;
  int learned_frames_ = 0;
  Ratios ratios_{};
};

/// Spreads each bin's count over its neighbours (binomial 1 2 1 along each channel), so that few
/// samples stand for the colours around them. `scratch` and `out` have kBinCount entries.
void smooth_histogram(std::span<const float> count, std::span<float> scratch,
                      std::span<float> out) noexcept;

}  // namespace handyar
