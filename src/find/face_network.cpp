// SPDX-License-Identifier: MIT
#include "find/face_network.hpp"

#include <algorithm>
#include <cmath>

#include "find/samples.hpp"

namespace handyar {
namespace {

#include "find/face_weights.inc"

using Complex = std::complex<float>;

constexpr int kSide = 96, kCells = kSide / 16, kChannels = 32;
// What it sees of the plane of an average hand, metres: its middle, and how far across.
constexpr Complex kMiddle_m(0.01f, -0.02f);
constexpr float kAcross_m = 0.25f;

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

SampleGrid grid_of(const Upright& upright) {
  constexpr float kSample_m = kAcross_m / kSide;
  const Complex first_m = kMiddle_m + 0.5f * Complex(kSample_m - kAcross_m, kAcross_m - kSample_m);
  const Complex right_px = kSample_m * upright.px_per_m;
  return {kSide,
          kSide,
          upright.to_frame(first_m),
          {upright.mirror * right_px.real(), -right_px.imag()},
          {upright.mirror * right_px.imag(), right_px.real()}};
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
  take_samples(frame, grid_of(upright), in.beside);
  const std::array<float, kOutputs> said = run(in);
  Look look{said[0], {}};
  for (int f = 0; f < kFingerCount; ++f) {
    const Complex halves(said[1 + 2 * f], -said[2 + 2 * f]);
    look.roots_px[f] = upright.to_frame(kMiddle_m + 0.5f * kAcross_m * halves);
  }
  return look;
}

}  // namespace handyar
