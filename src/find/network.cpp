// SPDX-License-Identifier: MIT
#include "find/network.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "vectorised.hpp"

namespace handyar {
namespace {

#include "find/finder_weights.inc"

/// Rows of pixels of channels.
struct Picture {
  int width, height, channels;
  constexpr int size() const { return width * height * channels; }
};

/// Weights of a layer in the order in which it wants them.
struct Reader {
  const float* at;
  const float* take(int count) {
    const float* first = at;
    at += count;
    return first;
  }
};

// Sums go over inputs in their order, for so many outputs at once as registers hold: vectors hold
// different outputs, never parts of one sum. Every layer but the last has a multiple of them.
constexpr int kSums = 16;

template <int kOutputs, int kPixels>
HANDYAR_ALWAYS_INLINE void mix(const float* in, int inputs, int outputs, const float* weights,
                               const float* bias, float* out) {
  float sum[kPixels][kOutputs];
  for (int p = 0; p < kPixels; ++p)
    HANDYAR_LANES for (int o = 0; o < kOutputs; ++o) sum[p][o] = bias[o];
  for (int i = 0; i < inputs; ++i) {
    const float* w = weights + i * outputs;
    for (int p = 0; p < kPixels; ++p) {
      const float x = in[p * inputs + i];
      HANDYAR_LANES for (int o = 0; o < kOutputs; ++o) sum[p][o] += x * w[o];
    }
  }
  for (int p = 0; p < kPixels; ++p)
    HANDYAR_LANES for (int o = 0; o < kOutputs; ++o) out[p * outputs + o] = sum[p][o];
}

template <int kOutputs>
HANDYAR_ALWAYS_INLINE void pointwise_to(const float* in, int pixels, int inputs, int outputs,
                                        const float* weights, const float* bias, float* out) {
  for (int o = 0; o < outputs; o += kOutputs) {
    int p = 0;
    for (; p + 2 <= pixels; p += 2)
      mix<kOutputs, 2>(in + p * inputs, inputs, outputs, weights + o, bias + o,
                       out + p * outputs + o);
    if (p < pixels)
      mix<kOutputs, 1>(in + p * inputs, inputs, outputs, weights + o, bias + o,
                       out + p * outputs + o);
  }
}

/// 1 x 1 convolution; `weights` output by output within an input.
HANDYAR_VECTORISED void pointwise(const float* in, int pixels, int inputs, int outputs,
                                  const float* weights, const float* bias, float* out) {
  if (outputs % kSums == 0)
    pointwise_to<kSums>(in, pixels, inputs, outputs, weights, bias, out);
  else
    pointwise_to<FinderNetwork::kOutputs>(in, pixels, inputs, outputs, weights, bias, out);
}

/// Each channel convolved with its own `side` x `side` weights, then at least 0.
HANDYAR_VECTORISED void depthwise(const float* in, Picture size, int side, int stride,
                                  const float* weights, const float* bias, float* out) {
  const int n = size.channels, half = side / 2;
  for (int y = 0; y < size.height; y += stride)
    for (int x = 0; x < size.width; x += stride)
      for (int c = 0; c < n; c += kSums, out += kSums) {
        float sum[kSums];
        HANDYAR_LANES for (int k = 0; k < kSums; ++k) sum[k] = bias[c + k];
        for (int dy = std::max(-half, -y); dy <= std::min(half, size.height - 1 - y); ++dy)
          for (int dx = std::max(-half, -x); dx <= std::min(half, size.width - 1 - x); ++dx) {
            const float* from = in + ((y + dy) * size.width + x + dx) * n + c;
            const float* w = weights + ((dy + half) * side + dx + half) * n + c;
            HANDYAR_LANES for (int k = 0; k < kSums; ++k) sum[k] += from[k] * w[k];
          }
        HANDYAR_LANES for (int k = 0; k < kSums; ++k) out[k] = std::max(sum[k], 0.0f);
      }
}

/// The first layer: 3 x 3, stride 2, of the colours about -2 to 2.
HANDYAR_VECTORISED void stem(const float* in, Picture size, const float* weights, const float* bias,
                             float* out) {
  constexpr int kOutputs = 16;
  for (int y = 0; y < size.height; y += 2)
    for (int x = 0; x < size.width; x += 2, out += kOutputs) {
      float sum[kOutputs];
      HANDYAR_LANES for (int o = 0; o < kOutputs; ++o) sum[o] = bias[o];
      for (int dy = std::max(-1, -y); dy <= std::min(1, size.height - 1 - y); ++dy)
        for (int dx = std::max(-1, -x); dx <= std::min(1, size.width - 1 - x); ++dx)
          for (int c = 0; c < 3; ++c) {
            const float value = (in[((y + dy) * size.width + x + dx) * 3 + c] - 127.5f) / 64;
            const float* w = weights + (((dy + 1) * 3 + dx + 1) * 3 + c) * kOutputs;
            HANDYAR_LANES for (int o = 0; o < kOutputs; ++o) sum[o] += value * w[o];
          }
      HANDYAR_LANES for (int o = 0; o < kOutputs; ++o) out[o] = std::max(sum[o], 0.0f);
    }
}

HANDYAR_VECTORISED void add(const float* other, int count, float* to) {
  for (int i = 0; i < count; ++i) to[i] = std::max(to[i] + other[i], 0.0f);
}

HANDYAR_VECTORISED void at_least_0(int count, float* to) {
  for (int i = 0; i < count; ++i) to[i] = std::max(to[i], 0.0f);
}

/// Adds a picture of half the size, each pixel to the four that it covers.
HANDYAR_VECTORISED void add_doubled(const float* half, Picture size, float* to) {
  const int half_width = (size.width + 1) / 2;
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x, to += size.channels) {
      const float* from = half + (y / 2 * half_width + x / 2) * size.channels;
      for (int c = 0; c < size.channels; ++c) to[c] += from[c];
    }
}

/// Depthwise, then pointwise, in place; with a shortcut where sizes allow.
Picture separable(std::vector<float>& picture, Picture size, int outputs, int side, int stride,
                  Reader& weights, std::vector<float>& spare) {
  const int n = size.channels;
  const float* depth = weights.take(side * side * n);
  const float* depth_bias = weights.take(n);
  const float* point = weights.take(n * outputs);
  const float* point_bias = weights.take(outputs);
  const Picture to{(size.width + stride - 1) / stride, (size.height + stride - 1) / stride,
                   outputs};
  const int pixels = to.width * to.height;
  depthwise(picture.data(), size, side, stride, depth, depth_bias, spare.data());
  if (stride == 1 && n == outputs) {
    float* mixed = spare.data() + pixels * n;
    pointwise(spare.data(), pixels, n, outputs, point, point_bias, mixed);
    add(mixed, to.size(), picture.data());
  } else {
    pointwise(spare.data(), pixels, n, outputs, point, point_bias, picture.data());
    at_least_0(to.size(), picture.data());
  }
  return to;
}

// Of any layer's picture, and of what is between its two halves.
constexpr int kMostNumbers = 80 * 60 * 16;
static_assert(kMostNumbers >= 2 * 40 * 30 * 32);

}  // namespace

FinderNetwork::FinderNetwork()
    : input_(kWidth * kHeight * 3),
      a_(kMostNumbers),
      b_(kMostNumbers),
      level1_(kCellsX * kCellsY * 32),
      level2_(20 * 15 * 64) {
  weights_.reserve(std::size(kFinderWeights) + 4096);
  std::size_t next = 0, of_scale = 0;
  for (const FinderBlock& block : kFinderBlocks) {
    // Each output's weights share a scale; biases are whole.
    for (int i = 0; i < block.weights; ++i)
      weights_.push_back(kFinderWeights[next++] * kFinderScales[of_scale + i % block.outputs]);
    of_scale += block.outputs;
    for (int o = 0; o < block.outputs; ++o) weights_.push_back(kFinderScales[of_scale + o]);
    of_scale += block.outputs;
  }
}

std::span<const float> FinderNetwork::run() noexcept {
  Reader weights{weights_.data()};
  const float* stem_weights = weights.take(27 * 16);
  const float* stem_bias = weights.take(16);
  stem(input_.data(), {kWidth, kHeight, 3}, stem_weights, stem_bias, a_.data());
  Picture size{kWidth / 2, kHeight / 2, 16};

  size = separable(a_, size, 32, 3, 2, weights, b_);
  size = separable(a_, size, 32, 3, 1, weights, b_);
  const Picture size1 = size;
  std::copy_n(a_.data(), size.size(), level1_.data());
  size = separable(a_, size, 64, 3, 2, weights, b_);
  for (int i = 0; i < 4; ++i) size = separable(a_, size, 64, 5, 1, weights, b_);
  const Picture size2 = size;
  std::copy_n(a_.data(), size.size(), level2_.data());
  size = separable(a_, size, 96, 3, 2, weights, b_);
  for (int i = 0; i < 10; ++i) size = separable(a_, size, 96, 5, 1, weights, b_);

  const auto up = [&](std::vector<float>& level, Picture to) {
    const float* point = weights.take(size.channels * to.channels);
    const float* bias = weights.take(to.channels);
    pointwise(a_.data(), size.width * size.height, size.channels, to.channels, point, bias,
              b_.data());
    add_doubled(b_.data(), to, level.data());
    std::copy_n(level.data(), to.size(), a_.data());
    size = to;
  };
  up(level2_, size2);
  size = separable(a_, size, 64, 3, 1, weights, b_);
  up(level1_, size1);
  for (int i = 0; i < 2; ++i) size = separable(a_, size, 32, 5, 1, weights, b_);

  const float* head = weights.take(32 * kOutputs);
  const float* head_bias = weights.take(kOutputs);
  pointwise(a_.data(), kCellsX * kCellsY, 32, kOutputs, head, head_bias, b_.data());
  return {b_.data(), static_cast<std::size_t>(kCellsX * kCellsY * kOutputs)};
}

}  // namespace handyar
