// SPDX-License-Identifier: MIT
#include "handyar/skin_model.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace handyar {
namespace {

// Two tables in one: skin, then everything else; -log probability in eighths of a nat.
constexpr std::uint8_t kPriorTable[2 * kBinCount] = {
#include "skin_prior_table.inc"
};

constexpr float kMinProbability = 1e-7f;  // below this a bin says nothing: too few pixels ever seen

/// RGB bin of a YCbCr bin's centre (full-range BT.601), or -1 outside the gamut.
int rgb_bin_of_ycbcr(int bin) {
  const double y = (bin >> 10) * 8 + 4.0, cb = ((bin >> 5) & 31) * 8 + 4.0 - 128;
  const double cr = (bin & 31) * 8 + 4.0 - 128;
  // Cameras deliver video range: 16..235 luma, 16..240 chroma.
  const double l = (y - 16) * 255 / 219;
  const double r = l + 1.596 * 255 / 255 * cr, g = l - 0.392 * cb - 0.813 * cr, b = l + 2.017 * cb;
  const double slack = 12;  // a bin is 8 wide: its centre may lie just outside
  for (const double c : {r, g, b})
    if (c < -slack || c > 255 + slack) return -1;
  const auto level = [](double c) { return std::clamp(static_cast<int>(c), 0, 255) >> 3; };
  return level(r) << 10 | level(g) << 5 | level(b);
}

/// Natural logarithm to 1e-3, by the exponent and a cubic; the table needs no more.
float fast_log(float x) {
  const auto bits = std::bit_cast<std::uint32_t>(x);
  const float exponent = static_cast<float>(static_cast<int>(bits >> 23) - 127);
  const float m = std::bit_cast<float>((bits & 0x007fffffu) | 0x3f800000u) - 1.0f;
  const float log2m = m * (1.4385f + m * (-0.6765f + m * (0.3196f - 0.0822f * m)));
  return 0.6931472f * (exponent + log2m);
}

}  // namespace

void smooth_histogram(std::span<const float> count, std::span<float> scratch,
                      std::span<float> out) noexcept {
  // Channel by channel; the outermost levels keep what would fall outside.
  const auto pass = [](const float* from, float* to, int stride) {
    for (int i = 0; i < kBinCount; i += stride * kBinLevels)
      for (int level = 0; level < kBinLevels; ++level) {
        const float* at = from + i + level * stride;
        const float* below = level > 0 ? at - stride : at;
        const float* above = level < kBinLevels - 1 ? at + stride : at;
        float* o = to + i + level * stride;
        for (int k = 0; k < stride; ++k) o[k] = 0.25f * below[k] + 0.5f * at[k] + 0.25f * above[k];
      }
  };
  pass(count.data(), out.data(), 1);
  pass(out.data(), scratch.data(), kBinLevels);
  pass(scratch.data(), out.data(), kBinLevels * kBinLevels);
}

SkinModel::SkinModel(const SkinModelConfig& config)
    : config_(config),
      prior_skin_(kBinCount),
      prior_other_(kBinCount),
      prior_skin_probability_(kBinCount),
      prior_other_probability_(kBinCount),
      scratch_(kBinCount) {
  for (Histogram* h : {&hand_, &background_}) {
    h->count.resize(kBinCount);
    h->smooth.resize(kBinCount);
  }
  reset(ColorSpace::rgb);
}

void SkinModel::reset(ColorSpace space) noexcept {
  float skin_total = 0, other_total = 0;
  for (int i = 0; i < kBinCount; ++i) {
    const int from = space == ColorSpace::rgb ? i : rgb_bin_of_ycbcr(i);
    prior_skin_[i] = from < 0 ? 255 : kPriorTable[from];
    prior_other_[i] = from < 0 ? 255 : kPriorTable[kBinCount + from];
    skin_total += prior_skin_probability_[i] = std::exp(-prior_skin_[i] / 8.0f);
    other_total += prior_other_probability_[i] = std::exp(-prior_other_[i] / 8.0f);
  }
  // Bins of YCbCr are not a partition of RGB's: probabilities must add up to one again.
  for (int i = 0; i < kBinCount; ++i) {
    prior_skin_probability_[i] /= skin_total;
    prior_other_probability_[i] /= other_total;
  }
  for (Histogram* h : {&hand_, &background_}) {
    std::ranges::fill(h->count, 0.0f);
    std::ranges::fill(h->smooth, 0.0f);
    h->total = 0;
  }
  learned_frames_ = 0;
  rebuild();
}

void SkinModel::accumulate(Histogram& h, std::span<const ColorBin> bins) noexcept {
  const float keep = 1.0f - 1.0f / static_cast<float>(std::max(config_.learn_frames, 1));
  for (float& c : h.count) c *= keep;
  for (const ColorBin b : bins) h.count[b] += 1;
  h.total = h.total * keep + static_cast<float>(bins.size());
}

void SkinModel::learn(std::span<const ColorBin> hand,
                      std::span<const ColorBin> background) noexcept {
  accumulate(hand_, hand);
  accumulate(background_, background);
  ++learned_frames_;
  rebuild();
}

void SkinModel::rebuild() noexcept {
  float hand_scale = 0, background_scale = 0, hand_prior = 1, background_prior = 1;
  const auto mix = [&](Histogram& h, double prior_weight, float& scale, float& prior) {
    if (h.total < 1) return;
    smooth_histogram(h.count, scratch_, h.smooth);
    prior = static_cast<float>(prior_weight);
    scale = (1 - prior) / h.total;
  };
  mix(hand_, config_.hand_prior_weight, hand_scale, hand_prior);
  mix(background_, config_.background_prior_weight, background_scale, background_prior);
  const float limit = 32;
  for (int i = 0; i < kBinCount; ++i) {
    const float hand = hand_scale * hand_.smooth[i] + hand_prior * prior_skin_probability_[i];
    const float background =
        background_scale * background_.smooth[i] + background_prior * prior_other_probability_[i];
    const float ratio =
        8 * (fast_log(hand + kMinProbability) - fast_log(background + kMinProbability));
    ratios_[i] = static_cast<std::int8_t>(std::clamp(ratio, -limit, limit));
  }
}

}  // namespace handyar
