// SPDX-License-Identifier: MIT
#include "find/face_network.hpp"

#include <algorithm>
#include <cmath>

#include "image/pixel_reader.hpp"

namespace handyar {
namespace {

#include "find/face_weights.inc"

using Complex = std::complex<float>;

constexpr int kSide = 96, kCells = kSide / 16, kChannels = 32;
// What it sees of the plane of an average hand, metres: its middle, and how far across.
constexpr Complex kMiddle_m(0.01f, -0.02f);
constexpr float kAcross_m = 0.25f;
// Of one sample so many pixels a side are read: fewer leave jagged edges, more take time.
constexpr int kLeastReads = 2, kMostReads = 3;
constexpr float kGrey = 127.5f;  // beyond the frame

using AverageTips = std::array<Complex, kFingerCount>;

/// A similarity from the plane of an average hand to the frame, both with y up and the thumb right,
/// so that its fingertips come about to those of the hand.
struct Upright {
  Complex px_per_m, offset_px;
  float mirror;  ///< -1 where the frame's x points the other way, for a hand with the thumb left

  Eigen::Vector2f to_frame(Complex p_m) const {
    const Complex p_px = px_per_m * p_m + offset_px;
    return {mirror * p_px.real(), -p_px.imag()};
  }
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
          const Eigen::Vector2f p_px = upright.to_frame(p_m);
          const int x = static_cast<int>(std::floor(p_px.x() + 0.5f)),
                    y = static_cast<int>(std::floor(p_px.y() + 0.5f));
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

std::array<float, FaceNetwork::kOutputs> FaceNetwork::run(layers::Workspace& in) const noexcept {
  layers::Reader weights{weights_.data()};
  layers::Picture size = layers::stem(in, {kSide, kSide, 3}, weights);
  const auto separable = [&](int outputs, int side, int stride) {
    size = layers::separable(in, size, outputs, side, stride, weights);
  };
  separable(32, 3, 1);
  separable(48, 3, 2);
  separable(48, 5, 1);
  separable(64, 3, 2);
  for (int i = 0; i < 2; ++i) separable(64, 5, 1);
  separable(kChannels, 3, 2);

  constexpr int kInputs = kCells * kCells * kChannels;
  const float* head = weights.take(kInputs * kOutputs);
  std::array<float, kOutputs> sums;
  std::copy_n(weights.take(kOutputs), kOutputs, sums.begin());
  for (int i = 0; i < kInputs; ++i)
    for (int o = 0; o < kOutputs; ++o) sums[o] += head[i * kOutputs + o] * in.picture[i];
  return sums;
}

FaceNetwork::Look FaceNetwork::look(const ImageView& frame, const HandPlace& hand, Layout layout,
                                    layers::Workspace& in) const noexcept {
  const Upright upright = upright_of(hand, layout, average_tips_m_);
  sample(frame, upright, in.beside);
  const std::array<float, kOutputs> said = run(in);
  Look look{said[0], {}};
  for (int f = 0; f < kFingerCount; ++f) {
    const Complex halves(said[1 + 2 * f], -said[2 + 2 * f]);
    look.roots_px[f] = upright.to_frame(kMiddle_m + 0.5f * kAcross_m * halves);
  }
  return look;
}

}  // namespace handyar
