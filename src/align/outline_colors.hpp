// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <span>
#include <vector>

#include "handyar/stages/hand_figure.hpp"
#include "image/color_bin.hpp"

namespace handyar {

/// Colours on both sides of the outline, as learned along it: for each finger and the palm apart,
/// since light differs from part to part, and together. Older frames fade.
class OutlineColors {
 public:
  static constexpr int kParts = kFingerCount + 1;

  OutlineColors() : bins_(kBinCount) {}

  void forget() noexcept;

  /// Begins the samples of a frame: what was learned before fades to `keep` of its weight.
  void fade(float keep) noexcept;

  void add(int part, ColorBin bin, bool hand) noexcept;
  /// Ends the samples of a frame. Where parts are not `told_apart` all have the hand's colours.
  void finish(bool told_apart) noexcept;

  /// Log likelihood ratios of hand against background for colours at a part, nats; 0 for a colour
  /// that was seen on neither side. At most kMostAsked at once.
  static constexpr int kMostAsked = 32;
  void log_ratios(int part, std::span<const ColorBin> bins, std::span<float> out) const noexcept;

  /// How common a colour is on a hand and behind it, as shares of the samples.
  struct Shares {
    float hand = 0, background = 0;

    /// 0 to 1, 1 for a colour of neither.
    float novelty() const noexcept;
    /// Nats. Of a colour of neither it says the more, the less new the hand's colours are
    /// elsewhere.
    float log_ratio(float novelty_elsewhere) const noexcept;
  };
  /// On the hand but for this part, and behind the rest.
  Shares shares_by_rest(int part, ColorBin bin) const noexcept;

 private:
  static constexpr int kTables = kParts + 1, kTogether = kParts;

  struct Counts {
    float hand = 0, background = 0;
  };

  /// What is asked together lies together: a bin's counts fill one line of the cache.
  struct alignas(64) Bin {
    std::array<Counts, kTables> tables{};
  };

  void normalise() noexcept;

  std::vector<Bin> bins_;
  std::array<Counts, kTables> totals_{};
  std::array<Counts, kTables> shares_{};  ///< of a count in its part's colours, in the mixture
  bool told_apart_ = true;
  float weight_ = 1;  ///< of a sample now; grows instead of the tables' fading
};

}  // namespace handyar
