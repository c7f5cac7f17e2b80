// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "image/color_bin.hpp"

namespace handyar::paper {

/// How likely each colour is skin (paper 2.1): the mixtures of Jones and Rehg at first, then the
/// histograms of the hand and of its surroundings over the last frames in which it was verified.
class SkinModel {
 public:
  explicit SkinModel(int learn_frames);

  /// Back to the mixtures.
  void reset() noexcept;

  /// Adds the colours of a verified hand and of what surrounds it.
  void learn(std::span<const ColorBin> hand, std::span<const ColorBin> background) noexcept;

  /// Log likelihood ratio of skin against anything else, nats.
  float log_ratio(ColorBin bin) const noexcept { return log_ratio_[bin]; }

 private:
  struct Histogram {
    std::vector<float> counts;
    float total = 0;

    void add(std::span<const ColorBin> bins, float keep) noexcept;
  };

  float keep_;  ///< of what was learned, from frame to frame
  Histogram hand_, background_;
  std::vector<float> log_ratio_;
};

}  // namespace handyar::paper
