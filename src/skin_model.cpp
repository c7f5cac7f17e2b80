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
constexpr int kPersonalPasses = 4;     // of smoothing: a standard deviation of 1.4 bins a channel
constexpr float kGeneralShare = 0.6f;  // of the general prior in a bare hand's personal one

/// The RGB bin in which a bin's centre lies, or -1 outside the gamut.
int rgb_bin_of(int bin, ColorSpace space) {
  const Eigen::Vector3d rgb = rgb_of(static_cast<ColorBin>(bin), space);
  constexpr double kSlack = 12;  // a bin is 8 wide: its centre may lie just outside
  if (rgb.minCoeff() < -kSlack || rgb.maxCoeff() > 255 + kSlack) return -1;
  const auto level = [](double c) { return std::clamp(static_cast<int>(c), 0, 255) >> 3; };
  return level(rgb[0]) << 10 | level(rgb[1]) << 5 | level(rgb[2]);
}

/// A personal prior in the form of the prior's table. As far as the colours are skin in general, a
/// part is left to the general prior: its wide flanks hold the shadows and edges of a bare hand,
/// without which fingertips come out short. Of a glove it knows nothing.
std::vector<std::uint8_t> prior_of(const SkinColors& colors) {
  std::vector<float> share(kBinCount), scratch(kBinCount), smooth(kBinCount);
  float skin = 0;  // share of the colours that are rather skin than not
  for (const SkinColors::Entry& e : colors.entries) {
    share[e.rgb_bin] += e.share;
    if (kPriorTable[e.rgb_bin] < kPriorTable[kBinCount + e.rgb_bin]) skin += e.share;
  }
  for (int pass = 0; pass < kPersonalPasses; ++pass) {
    smooth_histogram(share, scratch, smooth);
    share.swap(smooth);
  }
  const float general = kGeneralShare * std::clamp(skin, 0.0f, 1.0f);
  std::vector<std::uint8_t> table(kBinCount);
  for (int i = 0; i < kBinCount; ++i) {
    const float p = (1 - general) * share[i] + general * std::exp(-kPriorTable[i] / 8.0f);
    const float minus_log = -8 * std::log(std::max(p, kMinProbability));
    table[i] = static_cast<std::uint8_t>(std::clamp(minus_log + 0.5f, 0.0f, 255.0f));
  }
  return table;
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
  if (!config.personal.empty()) personal_ = prior_of(config.personal);
  reset(ColorSpace::rgb);
}

void SkinModel::reset(ColorSpace space) noexcept {
  space_ = space;
  const std::uint8_t* skin = personal_.empty() ? kPriorTable : personal_.data();
  float skin_total = 0, other_total = 0;
  for (int i = 0; i < kBinCount; ++i) {
    const int from = rgb_bin_of(i, space);
    prior_skin_[i] = from < 0 ? 255 : skin[from];
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

SkinColors SkinModel::learned_colors() const {
  SkinColors colors;
  std::vector<float> rgb(kBinCount);
  float total = 0;
  for (int i = 0; i < kBinCount; ++i) {
    const int to = hand_.count[i] > 0 ? rgb_bin_of(i, space_) : -1;
    if (to < 0) continue;
    rgb[to] += hand_.count[i];
    total += hand_.count[i];
  }
  for (int i = 0; i < kBinCount; ++i)
    if (rgb[i] > 0) colors.entries.push_back({static_cast<ColorBin>(i), rgb[i] / total});
  return colors;
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
