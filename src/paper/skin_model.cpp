// SPDX-License-Identifier: MIT
#include "paper/skin_model.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "image/fast_log.hpp"

namespace handyar::paper {
namespace {

// Two tables in one: skin, then everything else; -log probability in eighths of a nat.
constexpr std::uint8_t kPrior[2 * kBinCount] = {
#include "skin_prior_table.inc"
};

// The mixtures' say once a hand was seen: colours that were seen on neither side are rather not it.
constexpr float kHandPrior = 0.03f, kBackgroundPrior = 0.2f;
constexpr float kTiny = 1e-7f;

}  // namespace

SkinModel::SkinModel(int learn_frames)
    : keep_(1.0f - 1.0f / static_cast<float>(std::max(learn_frames, 1))),
      hand_{std::vector<float>(kBinCount)},
      background_{std::vector<float>(kBinCount)},
      log_ratio_(kBinCount) {
  reset();
}

void SkinModel::reset() noexcept {
  for (Histogram* h : {&hand_, &background_}) {
    std::fill(h->counts.begin(), h->counts.end(), 0.0f);
    h->total = 0;
  }
  for (int i = 0; i < kBinCount; ++i) log_ratio_[i] = (kPrior[kBinCount + i] - kPrior[i]) / 8.0f;
}

void SkinModel::Histogram::add(std::span<const ColorBin> bins, float keep) noexcept {
  for (float& count : counts) count *= keep;
  total *= keep;
  for (const ColorBin bin : bins) {
    counts[bin] += 1;
    // Neighbouring colours are seen too: few pixels stand for many.
    constexpr float kNeighbour = 0.3f;
    for (int shift = 0; shift <= kLumaShift; shift += 5) {
      const int level = bin >> shift & (kBinLevels - 1);
      if (level > 0) counts[bin - (1 << shift)] += kNeighbour;
      const int top = (shift == kLumaShift ? kLumaLevels : kBinLevels) - 1;
      if (level < top) counts[bin + (1 << shift)] += kNeighbour;
    }
    total += 1 + 6 * kNeighbour;
  }
}

void SkinModel::learn(std::span<const ColorBin> hand,
                      std::span<const ColorBin> background) noexcept {
  hand_.add(hand, keep_);
  background_.add(background, keep_);
  if (hand_.total <= 0 || background_.total <= 0) return;
  const float of_hand = (1 - kHandPrior) / hand_.total;
  const float of_background = (1 - kBackgroundPrior) / background_.total;
  for (int i = 0; i < kBinCount; ++i) {
    const float p = of_hand * hand_.counts[i] + kHandPrior * std::exp(-kPrior[i] / 8.0f);
    const float q = of_background * background_.counts[i] +
                    kBackgroundPrior * std::exp(-kPrior[kBinCount + i] / 8.0f);
    log_ratio_[i] = fast_log((p + kTiny) / (q + kTiny));
  }
}

}  // namespace handyar::paper
