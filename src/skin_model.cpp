// SPDX-License-Identifier: MIT
#include "handyar/skin_model.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "fast_log.hpp"
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
  ColorHistogram seen;
  float skin = 0;  // share of the colours that are rather skin than not
  for (const SkinColors::Entry& e : colors.entries) {
    seen.add(e.bin, e.share);
    if (kPriorTable[e.bin] < kPriorTable[kBinCount + e.bin]) skin += e.share;
  }
  const float general = kGeneralShare * std::clamp(skin, 0.0f, 1.0f);
  const BinSmoothing smoothing(kPersonalTimes);
  std::vector<std::uint8_t> table;
  table.reserve(kBinCount);
  BinPlane plane;
  for (int luma = 0; luma < kBinLevels; ++luma) {
    seen.smooth(smoothing, luma, plane);
    for (int row = 0; row < kBinLevels; ++row)
      for (const float share : plane.row(row)) {
        const float p =
            (1 - general) * share + general * std::exp(-kPriorTable[table.size()] / 8.0f);
        const float minus_log = -8 * std::log(std::max(p, kMinProbability));
        table.push_back(static_cast<std::uint8_t>(std::clamp(minus_log + 0.5f, 0.0f, 255.0f)));
      }
  }
  return table;
}

/// exp(-x / 8) to 1e-4: what an entry of the priors' tables stands for.
[[gnu::always_inline]] inline float probability_of(int x) {
  const float log2p = -0.18033688f * static_cast<float>(x);
  const int whole = static_cast<int>(log2p) - 1;
  const float part = log2p - static_cast<float>(whole);  // 0 .. 1
  const float m = 1 + part * (0.6954f + part * (0.2264f + part * 0.0782f));
  return m * std::bit_cast<float>((whole + 127) << 23);
}

/// Of a row of bins, hand or background: what was learned, and the prior.
struct RowShares {
  const float* count;
  const std::uint8_t* prior;
  float count_weight, prior_weight;
};

/// Ratios of a row of bins: of `all`, or of those that lie close to one that was seen.
HANDYAR_VECTORISED void mix_row(const RowShares& hand, const RowShares& background, bool all,
                                std::int8_t* __restrict out) {
  constexpr float kLimit = 32;
  constexpr int kBlock = 8;  // bins in a vector
  // No loop with numbers of several sizes: vectors are as full as the smallest.
  std::array<int, kBinLevels> hand_prior, background_prior, ratio;
  for (int k = 0; k < kBinLevels; ++k) hand_prior[k] = hand.prior[k];
  for (int k = 0; k < kBinLevels; ++k) background_prior[k] = background.prior[k];
  for (int k = 0; k < kBinLevels; ++k) ratio[k] = out[k];
  for (int first = 0; first < kBinLevels; first += kBlock) {
    std::uint32_t seen = all;  // no count is negative
    for (int k = first; k < first + kBlock; ++k)
      seen |= std::bit_cast<std::uint32_t>(hand.count[k]) |
              std::bit_cast<std::uint32_t>(background.count[k]);
    if (seen == 0) continue;
    for (int k = first; k < first + kBlock; ++k) {
      const float p =
          hand.count_weight * hand.count[k] + hand.prior_weight * probability_of(hand_prior[k]);
      const float q = background.count_weight * background.count[k] +
                      background.prior_weight * probability_of(background_prior[k]);
      const float log_ratio = fast_log(p + kMinProbability) - fast_log(q + kMinProbability);
      ratio[k] = static_cast<int>(std::clamp(8 * log_ratio, -kLimit, kLimit));
    }
  }
  for (int k = 0; k < kBinLevels; ++k) out[k] = static_cast<std::int8_t>(ratio[k]);
}

/// The colours of the hand or of the background: by the prior and, where enough of them were seen,
/// by those.
struct Colors {
  std::span<const std::uint8_t> prior;
  float prior_weight = 1, count_weight = 0;
  const ColorHistogram* seen = nullptr;
  BinSmoothing smoothing{};
  BinPlane plane{};  // of the seen ones, of one luma

  Colors(std::span<const std::uint8_t> prior_table, double weight)
      : prior(prior_table), prior_weight(static_cast<float>(weight)) {}
  Colors(std::span<const std::uint8_t> prior_table, double weight, const ColorHistogram& histogram,
         int smoothed)
      : Colors(prior_table, histogram.total() < 1 ? 1 : weight) {
    if (histogram.total() < 1) return;
    count_weight = (1 - prior_weight) / histogram.total();
    seen = &histogram;
    smoothing = BinSmoothing(smoothed);
  }
  void smooth(int luma) noexcept {
    if (seen != nullptr) seen->smooth(smoothing, luma, plane);
  }
  RowShares row(int luma, int r) const noexcept {
    return {plane.row(r).data(), prior.data() + first_bin(luma, r), count_weight, prior_weight};
  }
};

/// Ratios of all colours, or of those that were seen.
void mix(Colors hand, Colors background, bool all, SkinModel::Ratios& out) noexcept {
  constexpr std::uint32_t kAll = ~std::uint32_t{0};
  for (int luma = 0; luma < kBinLevels; ++luma) {
    hand.smooth(luma);
    background.smooth(luma);
    for_each_row(all ? kAll : hand.plane.filled | background.plane.filled, [&](int row) {
      mix_row(hand.row(luma, row), background.row(luma, row), all,
              out.data() + first_bin(luma, row));
    });
  }
}

}  // namespace

SkinModel::SkinModel(const SkinModelConfig& config) : config_(config), prior_ratios_{}, unseen_{} {
  if (!config.personal.empty()) personal_ = prior_of(config.personal);
  mix({prior_skin(), 1}, {prior_other(), 1}, true, prior_ratios_);
  mix({prior_skin(), config_.hand_prior_weight}, {prior_other(), config_.background_prior_weight},
      true, unseen_);
  learned_.ratios_ = prior_ratios_;
}

std::span<const std::uint8_t> SkinModel::prior_skin() const noexcept {
  if (!personal_.empty()) return personal_;
  return std::span(kPriorTable).first(kBinCount);
}

std::span<const std::uint8_t> SkinModel::prior_other() const noexcept {
  return std::span(kPriorTable).last(kBinCount);
}

void SkinModel::reset() noexcept {
  learned_.hand_.clear();
  learned_.background_.clear();
  learned_.frames_ = learned_.widening_ = 0;
  learned_.ratios_ = prior_ratios_;
  learned_.version_ = ++version_;
}

void SkinModel::forget_background() noexcept { learned_.background_.clear(); }

void SkinModel::widen() noexcept { learned_.widening_ = config_.widening; }

void SkinModel::learn(std::span<const ColorBin> hand,
                      std::span<const ColorBin> background) noexcept {
  const float keep = 1.0f - 1.0f / static_cast<float>(std::max(config_.learn_frames, 1));
  learned_.hand_.decay(keep);
  learned_.hand_.add(hand);
  learned_.background_.decay(keep);
  learned_.background_.add(background);
  ++learned_.frames_;
  ratios_of(learned_.hand_, learned_.background_, learned_.widening_, learned_.ratios_);
  learned_.version_ = ++version_;
  if (learned_.widening_ > 0) --learned_.widening_;
}

void SkinModel::keep(Learned& kept) const noexcept { kept = learned_; }

void SkinModel::restore(const Learned& kept) noexcept {
  if (kept.version_ != learned_.version_) learned_ = kept;
}

SkinColors SkinModel::colors_of(const Learned& learned) {
  SkinColors colors;
  if (learned.frames_ == 0) return colors;
  const ColorHistogram& hand = learned.hand_;
  for (int i = 0; i < kBinCount; ++i) {
    const auto bin = static_cast<ColorBin>(i);
    if (hand[bin] > 0) colors.entries.push_back({bin, hand[bin] / hand.total()});
  }
  return colors;
}

void SkinModel::ratios_of(const ColorHistogram& hand, const ColorHistogram& background,
                          int widening, Ratios& out) const noexcept {
  const Colors of_hand(prior_skin(), config_.hand_prior_weight, hand, 1 + widening);
  const Colors of_background(prior_other(), config_.background_prior_weight, background, 1);
  const bool both_seen = of_hand.seen != nullptr && of_background.seen != nullptr;
  if (both_seen) out = unseen_;
  mix(of_hand, of_background, !both_seen, out);
}

}  // namespace handyar
