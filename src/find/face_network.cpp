// SPDX-License-Identifier: MIT
#include "find/face_network.hpp"

#include <algorithm>
#include <cmath>

#include "image/pixel_reader.hpp"

namespace handyar {
namespace {

#include "find/face_weights.inc"

using Complex = std::complex<float>;

constexpr int kSide = 64, kCells = kSide / 8, kChannels = 64;
// What it sees of the plane of an average hand, metres: its middle, and how far across.
constexpr Complex kMiddle_m(0.01f, -0.01f);
constexpr float kAcross_m = 0.26f;
// Of one sample so many pixels a side are read: fewer leave jagged edges, more take time.
constexpr int kLeastReads = 2, kMostReads = 4;
constexpr float kGrey = 127.5f;  // beyond the frame

using AverageTips = std::array<Complex, kFingerCount>;

/// A similarity from the plane of an average hand to the frame, both with y up and the thumb right,
/// so that its fingertips come about to those of the hand.
struct Upright {
  Complex px_per_m, offset_px;
  float mirror;  ///< -1 where the frame's x points the other way, for a hand with the thumb left
};

Upright upright_of(const HandPlace& hand, Layout layout, const AverageTips& average_tips_m) {
  // Both planes have y up, and the thumb right.
  const float mirror = layout == Layout::thumb_left ? -1.0f : 1.0f;
  std::array<Complex, kFingerCount> to;
  Complex middle_m = 0, middle_px = 0;
  for (int f = 0; f < kFingerCount; ++f) {
    to[f] = {mirror * hand.tips_px[f].x(), -hand.tips_px[f].y()};
    middle_m += average_tips_m[f] / static_cast<float>(kFingerCount);
    middle_px += to[f] / static_cast<float>(kFingerCount);
  }
  Complex product = 0;
  float square = 0;
  for (int f = 0; f < kFingerCount; ++f) {
    const Complex from = average_tips_m[f] - middle_m;
    product += std::conj(from) * (to[f] - middle_px);
    square += std::norm(from);
  }
  const Complex px_per_m = product / square;
  return {px_per_m, middle_px - px_per_m * middle_m, mirror};
}

/// Means over the pixels of each sample.
void sample(const ImageView& frame, const Upright& upright, std::span<float> colors) {
  const PixelReader reader(frame);
  constexpr float kSample_m = kAcross_m / kSide;
  const float scale = kSample_m * std::abs(upright.px_per_m);
  const int reads = std::clamp(static_cast<int>(std::lround(scale)), kLeastReads, kMostReads);
  const float step_m = kSample_m / static_cast<float>(reads);
  const Complex first_m = kMiddle_m + 0.5f * Complex(step_m - kAcross_m, kAcross_m - step_m);
  float* out = colors.data();
  for (int v = 0; v < kSide; ++v)
    for (int u = 0; u < kSide; ++u, out += 3) {
      std::array<int, 3> sum{};
      int within = 0;
      for (int j = 0; j < reads; ++j)
        for (int i = 0; i < reads; ++i) {
          const Complex p_m = first_m + step_m * Complex(static_cast<float>(u * reads + i),
                                                         -static_cast<float>(v * reads + j));
          const Complex p_px = upright.px_per_m * p_m + upright.offset_px;
          const int x = static_cast<int>(std::floor(upright.mirror * p_px.real() + 0.5f)),
                    y = static_cast<int>(std::floor(0.5f - p_px.imag()));
          if (x < 0 || y < 0 || x >= frame.width_px || y >= frame.height_px) continue;
          const std::array<int, 3> rgb = reader.rgb(x, y);
          for (int c = 0; c < 3; ++c) sum[c] += rgb[c];
          ++within;
        }
      for (int c = 0; c < 3; ++c) out[c] = within > 0 ? static_cast<float>(sum[c]) / within : kGrey;
    }
}

}  // namespace

FaceNetwork::FaceNetwork() : weights_(layers::unpacked(kBlocks, kScales, kWeights)) {
  const HandModel average = average_adult_hand();
  for (int f = 0; f < kFingerCount; ++f)
    average_tips_m_[f] =
        Complex(static_cast<float>(average.tips_m(0, f)), static_cast<float>(average.tips_m(1, f)));
}

float FaceNetwork::run(layers::Workspace& in) const noexcept {
  layers::Reader weights{weights_.data()};
  layers::Picture size = layers::stem(in, {kSide, kSide, 3}, weights);
  const auto separable = [&](int outputs, int side, int stride) {
    size = layers::separable(in, size, outputs, side, stride, weights);
  };
  separable(32, 3, 1);
  separable(48, 3, 2);
  separable(48, 5, 1);
  separable(kChannels, 3, 2);
  for (int i = 0; i < 2; ++i) separable(kChannels, 5, 1);

  const float* head = weights.take(kCells * kCells * kChannels);
  float log_odds = *weights.take(1);
  for (int i = 0; i < kCells * kCells * kChannels; ++i) log_odds += head[i] * in.picture[i];
  return log_odds;
}

float FaceNetwork::palm_log_odds(const ImageView& frame, const HandPlace& hand, Layout layout,
                                 layers::Workspace& in) const noexcept {
  sample(frame, upright_of(hand, layout, average_tips_m_), in.colors);
  return run(in);
}

}  // namespace handyar
