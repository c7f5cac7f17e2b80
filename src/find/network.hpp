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
  /// Outputs of a cell: a palm with the thumb right, left; the tips.
  static constexpr int kPalms = 0, kTips = 2, kOutputs = 7;

  FinderNetwork();

  /// Where the next picture goes: red, green and blue of each pixel, 0 to 255.
  std::span<float> input() noexcept { return input_; }

  /// Runs it. kOutputs numbers for each cell; log odds. Valid until the next run.
  std::span<const float> run() noexcept;

 private:
  std::vector<float> weights_, input_, a_, b_, level1_, level2_;
};

}  // namespace handyar
