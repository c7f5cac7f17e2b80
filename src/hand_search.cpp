// SPDX-License-Identifier: MIT
#include "handyar/hand_search.hpp"

#include <algorithm>
#include <cmath>

namespace handyar {
namespace {

enum ChannelIndex {
  kSkin,
  kSkinDark,
  kPrior,
  kPriorDark,
  kScene,
  kLuma,
  kDark,
  kRed,
  kBlue,
  kChannels
};

struct Rgb {
  int r, g, b;
};

Rgb rgb_of(int bin, ColorSpace space) {
  const int a = (bin >> 10) * 8 + 4, b = ((bin >> 5) & 31) * 8 + 4, c = (bin & 31) * 8 + 4;
  if (space == ColorSpace::rgb) return {a, b, c};
  const double l = 1.164 * (a - 16), cb = b - 128, cr = c - 128;
  return {int(l + 1.596 * cr), int(l - 0.392 * cb - 0.813 * cr), int(l + 2.017 * cb)};
}

std::int8_t clamp8(double x) { return static_cast<std::int8_t>(std::clamp(x, -127.0, 127.0)); }

}  // namespace

HandSearch::HandSearch(const HandSearchConfig& config, const FingertipConfig& fingertips,
                       const HandShapeConfig& shape)
    : config_(config),
      shape_config_(shape),
      curvature_(fingertips),
      channels_(kChannels),
      scene_(kBinCount),
      scratch_(kBinCount),
      smooth_(kBinCount) {}

void HandSearch::reserve(int max_pixels) {
  region_.reserve(max_pixels);
  contour_.reserve(1 << 13);
}

void HandSearch::read_scene(const BinImage& image, const SkinModel& skin) noexcept {
  if (!fixed_channels_ready_) {
    fixed_channels_ready_ = true;
    for (int i = 0; i < kBinCount; ++i) {
      const Rgb p = rgb_of(i, space_);
      const double luma = 0.299 * p.r + 0.587 * p.g + 0.114 * p.b;
      channels_[kLuma][i] = clamp8(luma - 128);
      channels_[kDark][i] = clamp8(127 - luma);
      channels_[kRed][i] = clamp8(p.r - p.g);
      channels_[kBlue][i] = clamp8(0.5 * (p.r + p.g) - p.b);
      channels_[kPrior][i] = clamp8(skin.prior_other()[i] - skin.prior_skin()[i]);
    }
  }
  std::ranges::fill(scene_, 0.0f);
  for (const ColorBin b : image.used()) scene_[b] += 1;
  smooth_histogram(scene_, scratch_, smooth_);
  const float total = static_cast<float>(image.used().size());
  std::ranges::copy(skin.ratios(), channels_[kSkin].begin());
  for (int i = 0; i < kBinCount; ++i)
    channels_[kScene][i] =
        clamp8(-skin.prior_skin()[i] - 8 * std::log(std::max(smooth_[i] / total, 1e-6f)));
}

void HandSearch::add_levels(int channel, int levels) noexcept {
  // Thresholds that cut the scene's distribution of this channel where it is thin (Lloyd's
  // quantiser): between its clusters.
  std::array<float, 256> histogram{};
  for (int i = 0; i < kBinCount; ++i) histogram[channels_[channel][i] + 128] += scene_[i];
  std::array<float, 9> center;
  for (int k = 0; k <= levels; ++k) {
    float target = 0, total = 0;
    for (const float c : histogram) target += c;
    target *= (k + 0.5f) / static_cast<float>(levels + 1);
    int at = 0;
    while (at < 255 && (total += histogram[at]) < target) ++at;
    center[k] = static_cast<float>(at);
  }
  for (int pass = 0; pass < 8; ++pass) {
    std::array<float, 9> sum{}, weight{};
    int k = 0;
    for (int i = 0; i < 256; ++i) {
      while (k < levels && std::abs(i - center[k + 1]) < std::abs(i - center[k])) ++k;
      sum[k] += histogram[i] * i;
      weight[k] += histogram[i];
    }
    for (k = 0; k <= levels; ++k)
      if (weight[k] > 0) center[k] = sum[k] / weight[k];
  }
  for (int k = 0; k < levels; ++k)
    readings_[reading_count_++] = {channel,
                                   static_cast<int>(0.5f * (center[k] + center[k + 1])) - 128};
}

bool HandSearch::try_reading(const BinImage& image, const Reading& reading, HandShape& best,
                             Component& best_component) noexcept {
  region_.classify(image, channels_[reading.channel], reading.threshold, false);
  const int pixels = image.width * image.height;
  const auto components = region_.components(static_cast<int>(config_.min_area_share * pixels));
  bool found = false;
  for (const Component& c : components) {
    if (c.area > 0.7 * pixels || !contour_.trace(region_.mask(), c)) continue;
    const Disc disc = region_.deepest(c);
    // The deepest point may lie in a forearm or in something that hangs together with the hand.
    for (const float scale : {1.0f, 0.6f}) {
      if (disc.radius * scale < 5) continue;
      curvature_.find(contour_, disc.radius * scale);
      HandShape shape;
      if (!find_hand_shape(curvature_, contour_, region_.mask(), disc.radius * scale, shape_config_,
                           shape) ||
          shape.residual >= best.residual)
        continue;
      best = shape;
      best_component = c;
      found = true;
    }
  }
  return found;
}

bool HandSearch::find(const BinImage& image, ColorSpace space, const SkinModel& skin,
                      HandShape& shape) noexcept {
  if (space != space_) {
    space_ = space;
    fixed_channels_ready_ = false;
  }
  read_scene(image, skin);
  reading_count_ = 0;
  for (const int t : {0, 8, -8}) readings_[reading_count_++] = {kSkin, t};
  for (const int t : {-8, 0, 8, 16}) readings_[reading_count_++] = {kPrior, t};
  for (const int t : {-16, -8, 0, 8, 16}) readings_[reading_count_++] = {kScene, t};
  add_levels(kLuma, 5);
  add_levels(kDark, 5);
  add_levels(kRed, 5);
  add_levels(kBlue, 5);
  winner_ = -1;
  shape.residual = static_cast<float>(shape_config_.max_residual);
  Component component;
  for (int i = 0; i < reading_count_; ++i)
    if (try_reading(image, readings_[i], shape, component)) winner_ = i;
  if (winner_ < 0) return false;
  region_.classify(image, channels_[readings_[winner_].channel], readings_[winner_].threshold,
                   false);
  for (const Component& c : region_.components(component.area))
    if (c.label == component.label) component = c;
  region_.keep_only(component);
  return true;
}

}  // namespace handyar
