// SPDX-License-Identifier: MIT
#include "handyar/skin_model.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>

#include "vectorised.hpp"

namespace handyar {
namespace {

// Two tables in one: skin, then everything else; -log probability in eighths of a nat.
constexpr std::uint8_t kPriorTable[2 * kBinCount] = {
#include "skin_prior_table.inc"
};

constexpr float kMinProbability = 1e-7f;  // below this a bin says nothing: too few pixels ever seen
constexpr int kPersonalTimes = 4;         // smoothed: a standard deviation of 1.4 bins a channel
constexpr float kGeneralShare = 0.6f;     // of the general prior in a bare hand's personal one

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
  smooth_histogram(share, smooth, kPersonalTimes);
  const float general = kGeneralShare * std::clamp(skin, 0.0f, 1.0f);
  std::vector<std::uint8_t> table(kBinCount);
  for (int i = 0; i < kBinCount; ++i) {
    const float p = (1 - general) * smooth[i] + general * std::exp(-kPriorTable[i] / 8.0f);
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

/// Whether a row of counts holds any: they are never negative, and their bits are soon read.
[[gnu::always_inline]] inline bool any_of(const float* row) {
  std::uint32_t bits = 0;
  for (int k = 0; k < kBinLevels; ++k) bits |= std::bit_cast<std::uint32_t>(row[k]);
  return bits != 0;
}

/// Most rows are empty and only read.
HANDYAR_VECTORISED void decay(std::span<float> count, float keep) {
  constexpr float kForgotten = 1e-4f;  // of a sample
  for (float* row = count.data(); row < count.data() + count.size(); row += kBinLevels) {
    if (!any_of(row)) continue;
    for (int k = 0; k < kBinLevels; ++k) row[k] = row[k] * keep < kForgotten ? 0.0f : row[k] * keep;
  }
}

/// Binomial weights of levels so far apart.
struct Smoothing {
  static constexpr int kMostReach = 15;  // less than a channel's levels
  int reach;
  std::array<float, kBinLevels + 2> weight{};

  explicit Smoothing(int times) : reach(std::clamp(times, 0, kMostReach)) {
    weight[0] = 1;
    for (int time = 0; time < reach; ++time) {
      float before = weight[1];
      for (int apart = 0; apart <= time + 1; ++apart) {
        const float at = weight[apart];
        weight[apart] = 0.25f * before + 0.5f * at + 0.25f * weight[apart + 1];
        before = at;
      }
    }
  }
};

/// Levels of a channel that are smoothed among themselves: what would fall outside is mirrored.
struct Levels {
  int begin, end;

  int mirrored(int level) const {
    return level < begin ? 2 * begin - 1 - level : level >= end ? 2 * end - 1 - level : level;
  }
};

/// The fine levels of chroma of one row.
HANDYAR_VECTORISED void smooth_along(const Smoothing& s, const float* row, float* __restrict out) {
  constexpr int kLevels = kCoarseChroma - kFineChroma;
  std::array<float, 3 * kLevels> padded;  // from level kFineChroma - kLevels on
  for (int k = 0; k < kLevels; ++k) padded[kLevels + k] = row[kFineChroma + k];
  for (int k = 1; k <= s.reach; ++k) {
    padded[kLevels - k] = padded[kLevels + k - 1];
    padded[2 * kLevels - 1 + k] = padded[2 * kLevels - k];
  }
  std::array<float, kLevels> sum{};
  for (int apart = -s.reach; apart <= s.reach; ++apart) {
    const float weight = s.weight[std::abs(apart)];
    const float* from = padded.data() + kLevels + apart;
    for (int k = 0; k < kLevels; ++k) sum[k] += weight * from[k];
  }
  for (int k = 0; k < kFineChroma; ++k) out[k] = row[k];
  for (int k = 0; k < kLevels; ++k) out[kFineChroma + k] = sum[k];
  for (int k = kCoarseChroma; k < kBinLevels; ++k) out[k] = row[k];
}

/// Whole rows, in place: row `first` + `stride` * level for each level.
HANDYAR_VECTORISED void smooth_across(const Smoothing& s, Levels levels, int first, int stride,
                                      std::span<float> rows, BinRows& filled) {
  std::array<std::array<float, kBinLevels>, kBinLevels> before;
  std::uint32_t held = 0;  // a bit for each level that holds something
  for (int level = levels.begin; level < levels.end; ++level) {
    const int row = first + level * stride;
    if (!filled[row]) continue;
    held |= std::uint32_t{1} << level;
    for (int k = 0; k < kBinLevels; ++k) before[level][k] = rows[row * kBinLevels + k];
  }
  if (held == 0) return;
  for (int level = levels.begin; level < levels.end; ++level) {
    const std::uint64_t reached = ((std::uint64_t{2} << 2 * s.reach) - 1) << level >> s.reach;
    if ((held & reached) == 0) continue;
    std::array<float, kBinLevels> sum{};
    for (int apart = -s.reach; apart <= s.reach; ++apart) {
      const int from = levels.mirrored(level + apart);
      if ((held >> from & 1) == 0) continue;
      const float weight = s.weight[std::abs(apart)];
      for (int k = 0; k < kBinLevels; ++k) sum[k] += weight * before[from][k];
    }
    const int row = first + level * stride;
    filled[row] = true;
    for (int k = 0; k < kBinLevels; ++k) rows[row * kBinLevels + k] = sum[k];
  }
}

}  // namespace

BinRows smooth_histogram(std::span<const float> count, std::span<float> out, int times) noexcept {
  constexpr Levels kLuma{0, kBinLevels}, kChroma{kFineChroma, kCoarseChroma};
  const Smoothing smoothing(times);
  BinRows filled;
  for (std::size_t r = 0; r < filled.size(); ++r) {
    const float* row = count.data() + r * kBinLevels;
    filled[r] = any_of(row);
    if (filled[r]) smooth_along(smoothing, row, out.data() + r * kBinLevels);
  }
  for (int a = 0; a < kBinLevels; ++a)
    smooth_across(smoothing, kChroma, a * kBinLevels, 1, out, filled);
  for (int b = 0; b < kBinLevels; ++b) smooth_across(smoothing, kLuma, b, kBinLevels, out, filled);
  return filled;
}

SkinModel::SkinModel(const SkinModelConfig& config)
    : config_(config), hand_smooth_(kBinCount), background_smooth_(kBinCount) {
  for (Histogram* h : {&learned_.hand_, &learned_.background_}) h->count.resize(kBinCount);
  if (!config.personal.empty()) personal_ = prior_of(config.personal);
  for (int i = 0; i < 256; ++i) probability_[i] = std::exp(-i / 8.0f);
  rebuild();
  prior_ratios_ = learned_.ratios_;
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
  learned_.ratios_ = prior_ratios_;
  learned_.version_ = ++version_;
}

void SkinModel::forget_background() noexcept {
  std::ranges::fill(learned_.background_.count, 0.0f);
  learned_.background_.total = 0;
}

void SkinModel::widen() noexcept { learned_.widening_ = config_.widening; }

void SkinModel::accumulate(Histogram& h, std::span<const ColorBin> bins) noexcept {
  const float keep = 1.0f - 1.0f / static_cast<float>(std::max(config_.learn_frames, 1));
  decay(h.count, keep);
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
  const auto smooth = [&](const Histogram& h, double prior_weight, int times,
                          std::vector<float>& out) {
    Part part;
    if (h.total < 1) return part;
    part.rows = smooth_histogram(h.count, out, times);
    part.prior = static_cast<float>(prior_weight);
    part.scale = (1 - part.prior) / h.total;
    return part;
  };
  const Part hand =
      smooth(learned_.hand_, config_.hand_prior_weight, 1 + learned_.widening_, hand_smooth_);
  const Part background =
      smooth(learned_.background_, config_.background_prior_weight, 1, background_smooth_);
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
