// SPDX-License-Identifier: MIT
#include "handyar/hand_search.hpp"

#include <algorithm>
#include <cmath>

namespace handyar {
namespace {

enum ChannelIndex {
  kSkin,
  kPrior,
  kScene,  // log likelihood ratios, eighths of a nat
  kLuma,
  kRed,
  kBlue,  // plain differences of the colours
  kDark,
  kNotRed,
  kNotBlue,  // and their negatives: a hand may lie on either side of a threshold
  kPatch,
  kChannels
};

// Patches are compared at 16 levels a channel: they hold few pixels.
constexpr int kCoarseLevels = 16, kCoarseCount = kCoarseLevels * kCoarseLevels * kCoarseLevels;
constexpr int kPatchColumns = 10, kPatchRows = 8, kTriedPatches = 24;

int coarse(int bin) { return (bin >> 11) << 8 | ((bin >> 6) & 15) << 4 | ((bin >> 1) & 15); }

std::int8_t clamp8(double x) { return static_cast<std::int8_t>(std::clamp(x, -127.0, 127.0)); }

HandShapeConfig shape_to_look_for(const HandSearchConfig& config, HandShapeConfig shape) {
  shape.max_deviation = config.max_deviation;
  return shape;
}

}  // namespace

HandSearch::HandSearch(const HandSearchConfig& config, const FingertipConfig& fingertips,
                       const HandShapeConfig& shape, const HandShapeModel& model)
    : config_(config),
      shape_config_(shape_to_look_for(config, shape)),
      shape_model_(model),
      curvature_(fingertips),
      channels_(kChannels),
      scene_(kBinCount),
      scratch_(kBinCount),
      smooth_(kBinCount),
      scene_coarse_(kCoarseCount),
      patch_(kCoarseCount),
      patch_smooth_(kCoarseCount) {}

void HandSearch::reserve(int max_pixels, int max_side) {
  region_.reserve(max_pixels, max_side);
  contour_.reserve(1 << 13);
}

void HandSearch::reset() noexcept { next_ = 0; }

void HandSearch::read_scene(const BinImage& image, const SkinModel& skin) noexcept {
  if (!fixed_channels_ready_) {
    fixed_channels_ready_ = true;
    for (int i = 0; i < kBinCount; ++i) {
      const Eigen::Vector3d rgb = rgb_of(static_cast<ColorBin>(i), space_);
      const double luma = 0.299 * rgb[0] + 0.587 * rgb[1] + 0.114 * rgb[2];
      channels_[kLuma][i] = clamp8(luma - 128);
      channels_[kRed][i] = clamp8(rgb[0] - rgb[1]);
      channels_[kBlue][i] = clamp8(rgb[2] - 0.5 * (rgb[0] + rgb[1]));
      for (const int c : {kLuma, kRed, kBlue})
        channels_[c + kDark - kLuma][i] = static_cast<std::int8_t>(-channels_[c][i]);
      channels_[kPrior][i] = clamp8(skin.prior_other()[i] - skin.prior_skin()[i]);
    }
  }
  std::ranges::fill(scene_, 0.0f);
  for (const ColorBin b : image.used()) scene_[b] += 1;
  smooth_histogram(scene_, scratch_, smooth_);
  const float total = static_cast<float>(image.used().size());
  std::ranges::copy(skin.ratios(), channels_[kSkin].begin());
  std::ranges::fill(scene_coarse_, 0.0f);
  for (int i = 0; i < kBinCount; ++i) {
    scene_coarse_[coarse(i)] += smooth_[i] / total;
    channels_[kScene][i] =
        clamp8(-skin.prior_skin()[i] - 8 * std::log(std::max(smooth_[i] / total, 1e-6f)));
  }
}

void HandSearch::add_levels(int channel, int levels) noexcept {
  // Thresholds that cut the scene's distribution of this channel where it is thin (Lloyd's
  // quantiser): between its clusters.
  std::array<float, 256> histogram{};
  for (int i = 0; i < kBinCount; ++i) histogram[channels_[channel][i] + 128] += scene_[i];
  float sum_of_all = 0;
  for (const float c : histogram) sum_of_all += c;
  std::array<float, 9> center;
  for (int k = 0; k <= levels; ++k) {
    const float target = sum_of_all * ((k + 0.5f) / static_cast<float>(levels + 1));
    float total = 0;
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
  for (int k = 0; k < levels; ++k) {
    const int cut = static_cast<int>(0.5f * (center[k] + center[k + 1])) - 128;
    readings_[reading_count_++] = {channel, cut};
    readings_[reading_count_++] = {channel + kDark - kLuma, -cut};
  }
}

void HandSearch::list_readings(const BinImage& image) noexcept {
  reading_count_ = 0;
  const auto add = [&](const Reading& r) { readings_[reading_count_++] = r; };
  for (const int t : {-8, 0, 8, 16}) add({kPrior, t});
  for (const int t : {-16, -12, -8, -4, 0, 8}) add({kScene, t});
  for (const int channel : {kLuma, kRed, kBlue}) add_levels(channel, 5);
  // Patches, the most skin-like first; the darkest hand is still likelier skin than most things.
  std::array<std::pair<float, int>, kPatchColumns * kPatchRows> patches;
  for (int p = 0; p < static_cast<int>(patches.size()); ++p) {
    const int u0 = p % kPatchColumns * image.width / kPatchColumns;
    const int v0 = p / kPatchColumns * image.height / kPatchRows;
    float sum = 0;
    for (int v = v0; v < v0 + image.height / kPatchRows; v += 4)
      for (int u = u0; u < u0 + image.width / kPatchColumns; u += 4)
        sum += channels_[kPrior][image.bins[static_cast<std::size_t>(v) * image.width + u]];
    patches[p] = {-sum, p};
  }
  std::ranges::sort(patches);
  for (int k = 0; k < kTriedPatches; ++k) add({kPatch, 0, patches[k].second});
  // Interleave, so that a frame's turn holds readings of every kind.
  constexpr int kStride = 7;
  std::array<Reading, 128> mixed;
  for (int start = 0, k = 0; start < kStride; ++start)
    for (int i = start; i < reading_count_; i += kStride) mixed[k++] = readings_[i];
  std::copy_n(mixed.begin(), reading_count_, readings_.begin());
}

/// Fills the patch channel: colours of a patch against those of the whole frame.
void HandSearch::read_patch(const BinImage& image, int patch) noexcept {
  const int width = image.width / kPatchColumns, height = image.height / kPatchRows;
  const int u0 = patch % kPatchColumns * width, v0 = patch / kPatchColumns * height;
  std::ranges::fill(patch_, 0.0f);
  for (int v = v0; v < v0 + height; ++v)
    for (int u = u0; u < u0 + width; ++u)
      patch_[coarse(image.bins[static_cast<std::size_t>(v) * image.width + u])] += 1;
  // One level around each colour.
  for (int stride = 1; stride < kCoarseCount; stride *= kCoarseLevels) {
    for (int i = 0; i < kCoarseCount; ++i) {
      const int level = i / stride % kCoarseLevels;
      const float below = level > 0 ? patch_[i - stride] : patch_[i];
      const float above = level < kCoarseLevels - 1 ? patch_[i + stride] : patch_[i];
      patch_smooth_[i] = 0.25f * below + 0.5f * patch_[i] + 0.25f * above;
    }
    patch_.swap(patch_smooth_);
  }
  const float total = static_cast<float>(width * height);
  std::array<std::int8_t, kCoarseCount> ratio;
  for (int i = 0; i < kCoarseCount; ++i)
    ratio[i] = patch_[i] / total > 1.5f * scene_coarse_[i] + 1e-4f ? 1 : -1;
  for (int i = 0; i < kBinCount; ++i) channels_[kPatch][i] = ratio[coarse(i)];
}

void HandSearch::classify(const BinImage& image, const Reading& reading) noexcept {
  if (reading.patch >= 0) read_patch(image, reading.patch);
  region_.classify(image, channels_[reading.channel], reading.threshold);
  region_.remove_thin(1);
}

bool HandSearch::try_reading(const BinImage& image, const Reading& reading, HandShape& best,
                             Component& best_component) noexcept {
  classify(image, reading);
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
      if (!find_hand_shape(curvature_, contour_, region_.mask(), disc.radius * scale, shape_model_,
                           shape_config_, shape) ||
          shape.deviation >= best.deviation)
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
  list_readings(image);
  shape.deviation = static_cast<float>(shape_config_.max_deviation);
  Component component;
  int winner = -1;
  // What was learned comes first in every frame; the other readings take turns.
  readings_[reading_count_] = {kSkin, 0};
  if (try_reading(image, readings_[reading_count_], shape, component)) winner = reading_count_;
  for (int k = 0; k < std::min(config_.readings_per_frame, reading_count_); ++k) {
    const int i = (next_ + k) % reading_count_;
    if (try_reading(image, readings_[i], shape, component)) winner = i;
  }
  next_ = (next_ + config_.readings_per_frame) % reading_count_;
  if (winner < 0) return false;
  classify(image, readings_[winner]);
  for (const Component& c : region_.components(component.area))
    if (c.label == component.label) component = c;
  region_.keep_only(component);
  return true;
}

}  // namespace handyar
