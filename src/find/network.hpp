// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "find/layers.hpp"

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

  /// Runs it on the workspace's colours. kOutputs numbers for each cell; log odds. Valid until the
  /// workspace is used again.
  std::span<const float> run(layers::Workspace& in) noexcept;

 private:
  std::vector<float> weights_, level1_, level2_;
};

}  // namespace handyar
