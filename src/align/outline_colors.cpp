// SPDX-License-Identifier: MIT
#include "align/outline_colors.hpp"

#include <algorithm>

#include "image/fast_log.hpp"

namespace handyar {
namespace {

// A part's own colours count more than those of the whole hand, and a colour seen on neither side
// tells nothing (unchanged since the first trial of the figure).
constexpr float kOwn = 0.6f;
// The share of samples that says that a colour might come on either side.
constexpr float kUnseen = 2e-4f;
// There are more colours behind a hand than on it, and one that is known of neither is new to most
// of what lies there. A part has such colours as often as the hand's other parts have, or since it
// has a light of its own, so often. Changed clips have 1.3 % wrong frames so, 1.6 and 2.0 with a
// quarter and with 0.45.
constexpr float kOwnLight = 1.0f / 3;
// Samples lie on their bin and its neighbours, so that colours a little off are known.
constexpr float kCentre = 0.4f, kNeighbour = (1 - kCentre) / 6;
// No division by the samples of what was not seen yet.
constexpr float kTiny = 1e-20f;
// Of what is forgotten so much stays. With a hundredth of that the clips and hands that come back
// are as before but for chance.
constexpr float kLeastKept = 1e-3f;

}  // namespace

void OutlineColors::forget() noexcept {
  std::fill(bins_.begin(), bins_.end(), Bin{});
  totals_ = {};
  shares_ = {};
  weight_ = 1;
}

void OutlineColors::fade(float keep) noexcept {
  weight_ /= std::clamp(keep, kLeastKept, 1.0f);
  if (weight_ > 1e12f) normalise();
}

void OutlineColors::normalise() noexcept {
  const float scale = 1 / weight_;
  for (Bin& bin : bins_)
    for (Counts& c : bin.tables) c = {c.hand * scale, c.background * scale};
  for (Counts& c : totals_) c = {c.hand * scale, c.background * scale};
  weight_ = 1;
  finish(told_apart_);
}

void OutlineColors::add(int part, ColorBin bin, bool hand) noexcept {
  const auto put = [&](int at, float share) {
    Bin& counts = bins_[at];
    if (hand) {
      counts.tables[part].hand += share;
      counts.tables[kTogether].hand += share;
    } else {
      counts.tables[part].background += share;
      counts.tables[kTogether].background += share;
    }
  };
  put(bin, kCentre * weight_);
  for (int shift = 0; shift <= kLumaShift; shift += 5) {
    const int level = bin >> shift & (kBinLevels - 1);
    const int top = (shift == kLumaShift ? kLumaLevels : kBinLevels) - 1;
    put(level > 0 ? bin - (1 << shift) : bin, kNeighbour * weight_);
    put(level < top ? bin + (1 << shift) : bin, kNeighbour * weight_);
  }
  for (const int table : {part, kTogether})
    (hand ? totals_[table].hand : totals_[table].background) += weight_;
}

void OutlineColors::finish(bool told_apart) noexcept {
  told_apart_ = told_apart;
  const float own = told_apart ? kOwn : 0;
  for (int t = 0; t < kTables; ++t) {
    const float share = t == kTogether ? 1 - own : own;
    shares_[t] = {share / (totals_[t].hand + kTiny), share / (totals_[t].background + kTiny)};
  }
}

void OutlineColors::log_ratios(int part, std::span<const ColorBin> bins,
                               std::span<float> out) const noexcept {
  const Counts &of_own = shares_[part], &of_all = shares_[kTogether];
  std::array<float, kMostAsked> hand, background;
  hand.fill(1);
  background.fill(1);
  for (std::size_t i = 0; i < bins.size(); ++i) {
    const Counts& own = bins_[bins[i]].tables[part];
    const Counts& all = bins_[bins[i]].tables[kTogether];
    hand[i] = of_own.hand * own.hand + of_all.hand * all.hand + kUnseen;
    background[i] =
        of_own.background * own.background + of_all.background * all.background + kUnseen;
  }
  std::array<float, kMostAsked> ratio;
  for (int i = 0; i < kMostAsked; ++i) ratio[i] = fast_log(hand[i] / background[i]);
  std::copy_n(ratio.begin(), bins.size(), out.begin());
}

float OutlineColors::Shares::novelty() const noexcept {
  return kUnseen / (std::max(hand, background) + kUnseen);
}

float OutlineColors::Shares::log_ratio(float novelty_elsewhere) const noexcept {
  const float more_behind = std::max(1 / (novelty_elsewhere + kOwnLight), 1.0f);
  return fast_log((hand + kUnseen) / (background + more_behind * kUnseen));
}

OutlineColors::Shares OutlineColors::shares_by_rest(int part, ColorBin bin) const noexcept {
  const auto share = [](float of_all, float of_own, float all_samples, float own_samples) {
    return std::max(of_all - of_own, 0.0f) / (std::max(all_samples - own_samples, 0.0f) + kTiny);
  };
  const Counts &own = totals_[part], &all = totals_[kTogether];
  const Counts &of_own = bins_[bin].tables[part], &of_all = bins_[bin].tables[kTogether];
  return {share(of_all.hand, of_own.hand, all.hand, own.hand),
          share(of_all.background, of_own.background, all.background, own.background)};
}

}  // namespace handyar
