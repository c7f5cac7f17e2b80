// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace handyar::layers {

/// Rows of pixels of channels.
struct Picture {
  int width, height, channels;
  constexpr int size() const { return width * height * channels; }
};

/// So many weights of a layer, in 8 bits, and outputs with a scale and a bias each.
struct Block {
  int weights, outputs;
};

/// Weights as tools/finder/export.py packs them, in single precision: block by block, the weights,
/// each times its output's scale, then the biases. `scales`: scales of a block, then its biases.
std::vector<float> unpacked(std::span<const Block> blocks, std::span<const float> scales,
                            std::span<const std::int8_t> weights);

/// Weights of a layer in the order in which it wants them.
struct Reader {
  const float* at;
  const float* take(int count) {
    const float* first = at;
    at += count;
    return first;
  }
};

/// What networks are run in, one after the other: a layer's picture and, beside it, first the
/// frame's colours, red, green and blue of each pixel from 0 to 255, then what is between a layer's
/// two halves. As large as the largest network, the finder's, wants it.
struct Workspace {
  std::vector<float> picture = std::vector<float>(80 * 60 * 16),
                     beside = std::vector<float>(160 * 120 * 3);
};

/// What is done with a layer's sums: nothing, at least 0, or added to what is there, at least 0.
enum class Finish : std::uint8_t { none, at_least_0, add };

/// 1 x 1 convolution; `weights` output by output within an input.
void pointwise(const float* in, int pixels, int inputs, int outputs, const float* weights,
               const float* bias, Finish finish, float* out);

/// The first layer, at least 0: 3 x 3, stride 2, of the colours, to 16 channels.
Picture stem(Workspace& in, Picture size, Reader& weights);

/// Depthwise `side` x `side`, at least 0, then pointwise, at least 0, in place; with a shortcut
/// where sizes allow.
Picture separable(Workspace& in, Picture size, int outputs, int side, int stride, Reader& weights);

/// Adds a picture of half the size, each pixel to the four that it covers.
void add_doubled(const float* half, Picture size, float* to);

}  // namespace handyar::layers
