// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

namespace handyar {

/// The finder's network as tools/finder/network.py has it: layer by layer, in single precision, in
/// one order of sums, so that all machines give the same bits. Pictures are rows of pixels of
/// channels.
class FinderNetwork {
 public:
  static constexpr int kWidth = 160, kHeight = 120, kStride = 4;
  static constexpr int kCellsX = kWidth / kStride, kCellsY = kHeight / kStride;
  /// Outputs of a cell: a palm with the thumb right, left; the tips; x and y of each tip from the
  /// palm.
  static constexpr int kPalms = 0, kTips = 2, kOffsets = 7, kOutputs = 17;
  static constexpr float kOffsetUnit = 8;  ///< cells

  FinderNetwork();

  /// Log odds of a hand by its palm's logit and the mean support of its fingertips, 0 to 1.
  static float log_odds(float palm, float tip_support) noexcept;

  /// Where the next picture goes: red, green and blue of each pixel, 0 to 255.
  std::span<float> input() noexcept { return input_; }

  /// Runs it. kOutputs numbers for each cell; heat maps as logits. Valid until the next run.
  std::span<const float> run() noexcept;

 private:
  std::vector<float> weights_, input_, a_, b_, c_, level1_, level2_;
};

}  // namespace handyar
