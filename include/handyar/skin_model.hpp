// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "handyar/color_bins.hpp"
#include "handyar/color_histogram.hpp"

namespace handyar {

/// The colours of one hand or glove: a distribution over bins. Takes the place of the general skin
/// prior.
struct SkinColors {
  struct Entry {
    ColorBin bin = 0;
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
  int widening = 8;     ///< times that a newly found hand's colours are smoothed, see widen()
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

  /// What was learned: all that changes from frame to frame.
  class Learned {
    friend class SkinModel;
    ColorHistogram hand_, background_;
    Ratios ratios_{};
    int frames_ = 0;
    int widening_ = 0;
    std::uint32_t version_ = 0;  // no two that a model learned have the same
  };

  explicit SkinModel(const SkinModelConfig& config = {});

  /// Back to the prior.
  void reset() noexcept;

  /// The colours of the hand that are learned next stand for a wider range around them, less so
  /// with each frame: of a hand that was just found, in whatever light, few colours are known.
  void widen() noexcept;

  /// Adds a frame in which the hand was verified: bins of pixels that surely show it, and of pixels
  /// around it that surely do not.
  void learn(std::span<const ColorBin> hand, std::span<const ColorBin> background) noexcept;

  /// Forgets what surrounded the hand: it is found anew, perhaps before something else.
  void forget_background() noexcept;

  bool has_learned() const noexcept { return learned_.frames_ > 0; }

  /// Keeps what was learned so far in `kept`.
  void keep(Learned& kept) const noexcept;
  /// Back to what was kept.
  void restore(const Learned& kept) noexcept;

  /// Colours of the hand over the last frames; empty before anything was learned. Takes memory.
  SkinColors learned_colors() const { return colors_of(learned_); }
  static SkinColors colors_of(const Learned& learned);

  /// How often each bin was seen on the hand over the last frames.
  const ColorHistogram& learned_hand() const noexcept { return learned_.hand_; }

  const Ratios& ratios() const noexcept { return learned_.ratios_; }
  /// As they were before anything was learned.
  const Ratios& prior_ratios() const noexcept { return prior_ratios_; }

  /// What ratios() would be had nothing been learned but these colours of a newly found hand and of
  /// what surrounds it.
  void ratios_of_found(const ColorHistogram& hand, const ColorHistogram& background,
                       Ratios& out) const noexcept {
    ratios_of(hand, background, config_.widening, out);
  }

  /// -log probability in eighths of a nat of each bin under the prior alone, bin by bin.
  std::span<const std::uint8_t> prior_skin() const noexcept;
  std::span<const std::uint8_t> prior_other() const noexcept;

 private:
  void ratios_of(const ColorHistogram& hand, const ColorHistogram& background, int widening,
                 Ratios& out) const noexcept;

  SkinModelConfig config_;
  std::vector<std::uint8_t> personal_;  // a table like the prior's; empty: none
  Ratios prior_ratios_;                 // before anything was learned
  Ratios unseen_;  // once it was: of colours that were seen neither on the hand nor around it
  Learned learned_;
  std::uint32_t version_ = 0;
};

}  // namespace handyar
