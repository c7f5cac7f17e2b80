// SPDX-License-Identifier: MIT
#include "handyar/skin_model.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "vectorised.hpp"

namespace handyar {
namespace {

// Two tables in one: skin, then everything else; -log probability in eighths of a nat.
constexpr std::uint8_t kPriorTable[2 * kBinCount] = {
#include "skin_prior_table.inc"
};

constexpr float kMinProbability = 1e-7f;  // below this a bin says nothing: too few pixels ever seen
constexpr int kPersonalPasses = 4;     // of smoothing: a standard deviation of 1.4 bins a channel
constexpr float kGeneralShare = 0.6f;  // of the general prior in a bare hand's personal one

/// A personal prior in the form of the prior's table. As far as the colours are skin in general, a
/// part is left to the general prior: its wide flanks hold the shadows and edges of a bare hand,
/// without which fingertips come out short. Of a glove it knows nothing.
std::vector<std::uint8_t> prior_of(const SkinColors& colors) {
  std::vector<float> share(kBinCount), smooth(kBinCount);
  float skin = 0;  // share of the colours that are rather skin than not
  for (const SkinColors::Entry& e : colors.entries) {
    share[e.bin] += e.share;
    if (kPriorTable[e.bin] < kPriorTable[kBinCount + e.bin]) skin += e.share;
  }
  for (int pass = 0; pass < kPersonalPasses; ++pass) {
    smooth_histogram(share, smooth);
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
[[gnu::always_inline]] inline float fast_log(float x) {
  const auto bits = std::bit_cast<std::uint32_t>(x);
  const float exponent = static_cast<float>(static_cast<int>(bits >> 23) - 127);
  const float m = std::bit_cast<float>((bits & 0x007fffffu) | 0x3f800000u) - 1.0f;
  const float log2m = m * (1.4385f + m * (-0.6765f + m * (0.3196f - 0.0822f * m)));
  return 0.6931472f * (exponent + log2m);
}

/// Of a row of bins, hand or background: what was learned, and the prior.
struct RowShares {
  const float* count;
  const std::uint8_t* prior;
  float count_weight, prior_weight;
};

/// Ratios of a row of bins; `probability` is that of each entry of a prior's table.
HANDYAR_VECTORISED void mix_row(const RowShares& hand, const RowShares& background,
                                const float* probability, std::int8_t* __restrict out) {
  constexpr float kLimit = 32;
  std::array<float, kBinLevels> skin, other;
  for (int k = 0; k < kBinLevels; ++k) {
    skin[k] = probability[hand.prior[k]];
    other[k] = probability[background.prior[k]];
  }
  for (int k = 0; k < kBinLevels; ++k) {
    const float p = hand.count_weight * hand.count[k] + hand.prior_weight * skin[k];
    const float q =
        background.count_weight * background.count[k] + background.prior_weight * other[k];
    const float ratio = 8 * (fast_log(p + kMinProbability) - fast_log(q + kMinProbability));
    out[k] = static_cast<std::int8_t>(std::clamp(ratio, -kLimit, kLimit));
  }
}

}  // namespace

BinRows smooth_histogram(std::span<const float> count, std::span<float> out) noexcept {
  using Row = std::array<float, kBinLevels>;
  constexpr int kRows = kBinCount / kBinLevels;
  BinRows filled;
  // Channel by channel; the outermost levels keep what would fall outside. Coarse levels of chroma
  // are wide enough.
  for (int r = 0; r < kRows; ++r) {
    const float* p = count.data() + r * kBinLevels;
    float* q = out.data() + r * kBinLevels;
    std::uint32_t any = 0;  // of the bits: counts are never negative, and this is vectorised
    for (int k = 0; k < kBinLevels; ++k) any |= std::bit_cast<std::uint32_t>(p[k]);
    filled[r] = any != 0;
    std::copy_n(p, kBinLevels, q);
    if (!filled[r]) continue;
    constexpr int kFirst = kFineChroma, kLast = kCoarseChroma - 1;
    q[kFirst] = 0.25f * p[kFirst] + 0.5f * p[kFirst] + 0.25f * p[kFirst + 1];
    for (int k = kFirst + 1; k < kLast; ++k)
      q[k] = 0.25f * p[k - 1] + 0.5f * p[k] + 0.25f * p[k + 1];
    q[kLast] = 0.25f * p[kLast - 1] + 0.5f * p[kLast] + 0.25f * p[kLast];
  }
  // In place: of the rows along a channel, the one below as it was is kept aside.
  const auto along = [&](int first, int stride, int levels) {
    Row below, at;
    bool below_filled = filled[first];
    std::copy_n(out.data() + first * kBinLevels, kBinLevels, below.data());
    for (int level = 0, r = first; level < levels; ++level, r += stride) {
      const int above = level < levels - 1 ? r + stride : r;
      const bool at_filled = filled[r];
      if (!below_filled && !at_filled && !filled[above]) continue;  // `below` is empty too
      float* q = out.data() + r * kBinLevels;
      std::copy_n(q, kBinLevels, at.data());
      const float* p = above == r ? at.data() : out.data() + above * kBinLevels;
      for (int k = 0; k < kBinLevels; ++k) q[k] = 0.25f * below[k] + 0.5f * at[k] + 0.25f * p[k];
      filled[r] = true;
      below = at;
      below_filled = at_filled;
    }
  };
  for (int a = 0; a < kBinLevels; ++a)
    along(a * kBinLevels + kFineChroma, 1, kCoarseChroma - kFineChroma);
  for (int b = 0; b < kBinLevels; ++b) along(b, kBinLevels, kBinLevels);
  return filled;
}

SkinModel::SkinModel(const SkinModelConfig& config)
    : config_(config), hand_smooth_(kBinCount), background_smooth_(kBinCount) {
  for (Histogram* h : {&learned_.hand_, &learned_.background_}) h->count.resize(kBinCount);
  if (!config.personal.empty()) personal_ = prior_of(config.personal);
  for (int i = 0; i < 256; ++i) probability_[i] = std::exp(-i / 8.0f);
  reset();
}

std::span<const std::uint8_t> SkinModel::prior_skin() const noexcept {
  if (!personal_.empty()) return personal_;
  return std::span(kPriorTable).first(kBinCount);
}

std::span<const std::uint8_t> SkinModel::prior_other() const noexcept {
  return std::span(kPriorTable).last(kBinCount);
}

void SkinModel::reset() noexcept {
  for (Histogram* h : {&learned_.hand_, &learned_.background_}) {
    std::ranges::fill(h->count, 0.0f);
    h->total = 0;
  }
  learned_.frames_ = learned_.widening_ = 0;
  hand_prior_ = background_prior_ = 0;
  rebuild();
}

void SkinModel::forget_background() noexcept {
  std::ranges::fill(learned_.background_.count, 0.0f);
  learned_.background_.total = 0;
}

void SkinModel::widen() noexcept { learned_.widening_ = config_.widening; }

void SkinModel::accumulate(Histogram& h, std::span<const ColorBin> bins) noexcept {
  const float keep = 1.0f - 1.0f / static_cast<float>(std::max(config_.learn_frames, 1));
  constexpr float kForgotten = 1e-4f;  // of a sample
  for (float& c : h.count) c = c * keep < kForgotten ? 0.0f : c * keep;
  for (const ColorBin b : bins) h.count[b] += 1;
  h.total = h.total * keep + static_cast<float>(bins.size());
}

void SkinModel::learn(std::span<const ColorBin> hand,
                      std::span<const ColorBin> background) noexcept {
  accumulate(learned_.hand_, hand);
  accumulate(learned_.background_, background);
  ++learned_.frames_;
  rebuild();
  if (learned_.widening_ > 0) --learned_.widening_;
}

void SkinModel::keep(Learned& kept) const { kept = learned_; }

void SkinModel::restore(const Learned& kept) noexcept {
  if (kept.version_ != learned_.version_) learned_ = kept;
}

SkinColors SkinModel::colors_of(const Learned& learned) {
  SkinColors colors;
  if (learned.frames_ == 0) return colors;
  const Histogram& hand = learned.hand_;
  for (int i = 0; i < kBinCount; ++i)
    if (hand.count[i] > 0)
      colors.entries.push_back({static_cast<ColorBin>(i), hand.count[i] / hand.total});
  return colors;
}

void SkinModel::rebuild() noexcept {
  static constexpr float kEmpty[kBinLevels] = {};
  constexpr int kRows = kBinCount / kBinLevels;
  struct Part {
    BinRows rows{};
    float scale = 0, prior = 1;
  };
  const auto smooth = [&](const Histogram& h, double prior_weight, std::vector<float>& out) {
    Part part;
    if (h.total < 1) return part;
    part.rows = smooth_histogram(h.count, out);
    part.prior = static_cast<float>(prior_weight);
    part.scale = (1 - part.prior) / h.total;
    return part;
  };
  Part hand = smooth(learned_.hand_, config_.hand_prior_weight, hand_smooth_);
  for (int k = 0; k < learned_.widening_; ++k) {
    hand_smooth_.swap(background_smooth_);  // which comes after
    hand.rows = smooth_histogram(background_smooth_, hand_smooth_);
  }
  const Part background =
      smooth(learned_.background_, config_.background_prior_weight, background_smooth_);
  const auto mix = [&](int row, const float* hand_count, const float* background_count,
                       Ratios& ratios) {
    const int first = row * kBinLevels;
    mix_row({hand_count, prior_skin().data() + first, hand.scale, hand.prior},
            {background_count, prior_other().data() + first, background.scale, background.prior},
            probability_.data(), ratios.data() + first);
  };
  if (hand.prior != hand_prior_ || background.prior != background_prior_) {
    hand_prior_ = hand.prior;
    background_prior_ = background.prior;
    for (int r = 0; r < kRows; ++r) mix(r, kEmpty, kEmpty, unseen_);
  }
  learned_.ratios_ = unseen_;
  for (int r = 0; r < kRows; ++r) {
    if (!hand.rows[r] && !background.rows[r]) continue;
    const auto row = [&](const Part& part, const std::vector<float>& counts) {
      return part.rows[r] ? counts.data() + r * kBinLevels : kEmpty;
    };
    mix(r, row(hand, hand_smooth_), row(background, background_smooth_), learned_.ratios_);
  }
  learned_.version_ = ++version_;
}

}  // namespace handyar
