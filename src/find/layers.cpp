// SPDX-License-Identifier: MIT
#include "find/layers.hpp"

#include <algorithm>
#include <cstddef>

#include "vectorised.hpp"

namespace handyar::layers {
namespace {

// Sums go over inputs in their order, for so many outputs at once as registers hold: vectors hold
// different outputs, never parts of one sum. Every layer but the last has a multiple of them.
constexpr int kSums = 16, kLastSums = 7;

template <int kOutputs, int kPixels>
HANDYAR_ALWAYS_INLINE void mix(const float* in, int inputs, int outputs, const float* weights,
                               const float* bias, Finish finish, float* out) {
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
  for (int p = 0; p < kPixels; ++p) {
    float* to = out + p * outputs;
    if (finish == Finish::add) HANDYAR_LANES for (int o = 0; o < kOutputs; ++o) sum[p][o] += to[o];
    if (finish != Finish::none)
      HANDYAR_LANES for (int o = 0; o < kOutputs; ++o) sum[p][o] = std::max(sum[p][o], 0.0f);
    HANDYAR_LANES for (int o = 0; o < kOutputs; ++o) to[o] = sum[p][o];
  }
}

template <int kOutputs>
HANDYAR_ALWAYS_INLINE void pointwise_to(const float* in, int pixels, int inputs, int outputs,
                                        const float* weights, const float* bias, Finish finish,
                                        float* out) {
  for (int o = 0; o < outputs; o += kOutputs) {
    int p = 0;
    for (; p + 2 <= pixels; p += 2)
      mix<kOutputs, 2>(in + p * inputs, inputs, outputs, weights + o, bias + o, finish,
                       out + p * outputs + o);
    if (p < pixels)
      mix<kOutputs, 1>(in + p * inputs, inputs, outputs, weights + o, bias + o, finish,
                       out + p * outputs + o);
  }
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

/// 3 x 3, stride 2, of the colours about -2 to 2.
HANDYAR_VECTORISED void stem_of(const float* in, Picture size, const float* weights,
                                const float* bias, float* out) {
  constexpr int kOutputs = kSums;
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

HANDYAR_VECTORISED void pointwise_of(const float* in, int pixels, int inputs, int outputs,
                                     const float* weights, const float* bias, Finish finish,
                                     float* out) {
  if (outputs % kSums == 0)
    pointwise_to<kSums>(in, pixels, inputs, outputs, weights, bias, finish, out);
  else
    pointwise_to<kLastSums>(in, pixels, inputs, outputs, weights, bias, finish, out);
}

HANDYAR_VECTORISED void add_doubled_of(const float* half, Picture size, float* to) {
  const int half_width = (size.width + 1) / 2;
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x, to += size.channels) {
      const float* from = half + (y / 2 * half_width + x / 2) * size.channels;
      for (int c = 0; c < size.channels; ++c) to[c] += from[c];
    }
}

}  // namespace

std::vector<float> unpacked(std::span<const Block> blocks, std::span<const float> scales,
                            std::span<const std::int8_t> weights) {
  std::vector<float> all;
  all.reserve(weights.size() + scales.size() / 2);
  std::size_t next = 0, of_scale = 0;
  for (const Block& block : blocks) {
    for (int i = 0; i < block.weights; ++i)
      all.push_back(weights[next++] * scales[of_scale + i % block.outputs]);
    of_scale += block.outputs;
    for (int o = 0; o < block.outputs; ++o) all.push_back(scales[of_scale + o]);
    of_scale += block.outputs;
  }
  return all;
}

// A function that is compiled twice is seen from outside of the shared library; these are not.
void pointwise(const float* in, int pixels, int inputs, int outputs, const float* weights,
               const float* bias, Finish finish, float* out) {
  pointwise_of(in, pixels, inputs, outputs, weights, bias, finish, out);
}

void add_doubled(const float* half, Picture size, float* to) { add_doubled_of(half, size, to); }

Picture stem(Workspace& in, Picture size, Reader& weights) {
  const float* own = weights.take(3 * 3 * 3 * kSums);
  const float* bias = weights.take(kSums);
  stem_of(in.beside.data(), size, own, bias, in.picture.data());
  return {(size.width + 1) / 2, (size.height + 1) / 2, kSums};
}

Picture separable(Workspace& in, Picture size, int outputs, int side, int stride, Reader& weights) {
  float* const picture = in.picture.data();
  float* const halfway = in.beside.data();
  const int n = size.channels;
  const float* depth = weights.take(side * side * n);
  const float* depth_bias = weights.take(n);
  const float* point = weights.take(n * outputs);
  const float* point_bias = weights.take(outputs);
  const Picture to{(size.width + stride - 1) / stride, (size.height + stride - 1) / stride,
                   outputs};
  const int pixels = to.width * to.height;
  depthwise(picture, size, side, stride, depth, depth_bias, halfway);
  const bool has_shortcut = stride == 1 && n == outputs;
  pointwise(halfway, pixels, n, outputs, point, point_bias,
            has_shortcut ? Finish::add : Finish::at_least_0, picture);
  return to;
}

}  // namespace handyar::layers
