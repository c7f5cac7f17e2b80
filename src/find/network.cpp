// SPDX-License-Identifier: MIT
#include "find/network.hpp"

#include <algorithm>

namespace handyar {
namespace {

using layers::Picture;

#include "find/finder_weights.inc"

}  // namespace

FinderNetwork::FinderNetwork()
    : weights_(layers::unpacked(kBlocks, kScales, kWeights)),
      level1_(kCellsX * kCellsY * 32),
      level2_(20 * 15 * 64) {}

std::span<const float> FinderNetwork::run(layers::Workspace& in) noexcept {
  layers::Reader weights{weights_.data()};
  Picture size = layers::stem(in, {kWidth, kHeight, 3}, weights);
  const auto separable = [&](int outputs, int side, int stride) {
    size = layers::separable(in, size, outputs, side, stride, weights);
  };

  separable(32, 3, 2);
  separable(32, 3, 1);
  const Picture size1 = size;
  std::copy_n(in.picture.data(), size.size(), level1_.data());
  separable(64, 3, 2);
  for (int i = 0; i < 4; ++i) separable(64, 5, 1);
  const Picture size2 = size;
  std::copy_n(in.picture.data(), size.size(), level2_.data());
  separable(96, 3, 2);
  for (int i = 0; i < 10; ++i) separable(96, 5, 1);

  const auto up = [&](std::vector<float>& level, Picture to) {
    const float* point = weights.take(size.channels * to.channels);
    const float* bias = weights.take(to.channels);
    layers::pointwise(in.picture.data(), size.width * size.height, size.channels, to.channels,
                      point, bias, layers::Finish::none, in.beside.data());
    layers::add_doubled(in.beside.data(), to, level.data());
    std::copy_n(level.data(), to.size(), in.picture.data());
    size = to;
  };
  up(level2_, size2);
  separable(64, 3, 1);
  up(level1_, size1);
  for (int i = 0; i < 2; ++i) separable(32, 5, 1);

  const float* head = weights.take(32 * kOutputs);
  const float* head_bias = weights.take(kOutputs);
  layers::pointwise(in.picture.data(), kCellsX * kCellsY, 32, kOutputs, head, head_bias,
                    layers::Finish::none, in.beside.data());
  return {in.beside.data(), static_cast<std::size_t>(kCellsX * kCellsY * kOutputs)};
}

}  // namespace handyar
