// SPDX-License-Identifier: MIT
#include "handyar/hand_search.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "fast_log.hpp"
#include "skin_samples.hpp"
#include "vectorised.hpp"

namespace handyar {
namespace {

// Patches are compared at 16 levels a channel: they hold few pixels.
constexpr int kCoarseLevels = 16, kCoarseCount = kCoarseLevels * kCoarseLevels * kCoarseLevels;
constexpr int kPatchColumns = 10, kPatchRows = 8, kTriedPatches = 24;

int coarse(int bin) { return (bin >> 11) << 8 | ((bin >> 6) & 15) << 4 | ((bin >> 1) & 15); }

/// What else than a ratio is read of a colour: a sum of Y, Cb and Cr, bin by bin. A compiler takes
/// about a million steps: hence the levels beforehand, and pointers.
constexpr std::array<std::int8_t, kBinCount> channel(double of_y, double of_cb, double of_cr,
                                                     double offset) {
  std::array<std::int8_t, kBinCount> out{};
  std::int8_t* to = out.data();
  double redness[kBinLevels] = {};
  for (int k = 0; k < kBinLevels; ++k) redness[k] = of_cr * ycbcr_of(static_cast<ColorBin>(k))[2];
  for (int row = 0; row < kBinLevels * kBinLevels; ++row) {
    const auto [y, cb, cr] = ycbcr_of(static_cast<ColorBin>(row * kBinLevels));
    const double luma_and_yellowness = of_y * y + of_cb * cb;
    for (const double of_redness : redness) {
      const double x = luma_and_yellowness + of_redness + offset;
      *to++ = static_cast<std::int8_t>(x < -127 ? -127 : x > 127 ? 127 : x);
    }
  }
  return out;
}
constexpr auto kLuma = channel(1, 0, 0, -128);
constexpr auto kRedness = channel(0, 0.344136, 2.116136, 0);    // R - G
constexpr auto kBlueness = channel(0, 1.944068, -0.343932, 0);  // B - (R + G) / 2

// Bounds that a hand of five spread fingers keeps with a wide margin; they spare most regions a
// closer look. Lobed: the squared length of the boundary over that of a disc of the same area.
constexpr float kLeastLobed = 3, kMostLobed = 45;
constexpr float kLeastPalm = 6.7f;  // pixels: fingers of three, as thin as remove_thin(1) leaves

bool may_be_hand(const Component& c, const Contour& contour) {
  const float lobed =
      contour.perimeter() * contour.perimeter() / (4 * std::numbers::pi_v<float> * c.area);
  return lobed > kLeastLobed && lobed < kMostLobed;
}

/// Shares of a row of bins: counts and what each counts.
struct Share {
  const float* count;
  float weight;
};
constexpr float kLeastShare = 1e-6f;

/// How much more of each colour the one has than the other: the log of the ratio, in eighths of a
/// nat. In loops of numbers of one size, so that vectors are full.
HANDYAR_VECTORISED void compare(const Share& one, const Share& other, std::int8_t* __restrict out) {
  std::array<int, kBinLevels> ratio;
  for (int k = 0; k < kBinLevels; ++k) {
    const float log_ratio = fast_log(one.weight * one.count[k] + kLeastShare) -
                            fast_log(other.weight * other.count[k] + kLeastShare);
    ratio[k] = static_cast<int>(std::clamp(8 * log_ratio, -127.0f, 127.0f));
  }
  for (int k = 0; k < kBinLevels; ++k) out[k] = static_cast<std::int8_t>(ratio[k]);
}

/// The same for a prior's table, which holds -log probability in eighths of a nat.
HANDYAR_VECTORISED void compare_with_prior(const std::uint8_t* prior, const Share& other,
                                           std::int8_t* __restrict out) {
  std::array<int, kBinLevels> ratio;
  for (int k = 0; k < kBinLevels; ++k) ratio[k] = prior[k];
  for (int k = 0; k < kBinLevels; ++k) {
    const float log_share = fast_log(std::max(other.weight * other.count[k], kLeastShare));
    ratio[k] = static_cast<int>(
        std::clamp(-8 * log_share - static_cast<float>(ratio[k]), -127.0f, 127.0f));
  }
  for (int k = 0; k < kBinLevels; ++k) out[k] = static_cast<std::int8_t>(ratio[k]);
}

/// Sets bit k of the marks of a luma's bins whose channel is above the threshold, or below it.
HANDYAR_VECTORISED void mark_rows(const std::int8_t* channel, std::uint32_t rows, bool below,
                                  std::int8_t threshold, int k, std::uint32_t* __restrict marks) {
  for_each_row(rows, [&](int row) {
    const std::int8_t* const at = channel + row * kBinLevels;
    std::uint32_t* const to = marks + row * kBinLevels;
    std::array<std::uint8_t, kBinLevels> beyond;
    if (below)
      for (int i = 0; i < kBinLevels; ++i) beyond[i] = at[i] < threshold;
    else
      for (int i = 0; i < kBinLevels; ++i) beyond[i] = at[i] > threshold;
    for (int i = 0; i < kBinLevels; ++i) to[i] |= std::uint32_t{beyond[i]} << k;
  });
}

/// Spreads counts of coarse colours over the neighbouring levels of one channel (1 2 1).
template <int kStride>
void smooth_along(const float* count, float* __restrict out) {
  for (int first = 0; first < kCoarseCount; first += kCoarseLevels * kStride)
    for (int level = 0; level < kCoarseLevels; ++level) {
      const float* at = count + first + level * kStride;
      const float* below = level > 0 ? at - kStride : at;
      const float* above = level < kCoarseLevels - 1 ? at + kStride : at;
      float* to = out + first + level * kStride;
      for (int k = 0; k < kStride; ++k) to[k] = 0.25f * below[k] + 0.5f * at[k] + 0.25f * above[k];
    }
}

constexpr int kBlocks = 8;  // of 32 pixels, side by side in a vector
using MarksOfBlocks = std::array<std::uint32_t, kBlocks>;

/// In each of the blocks, bit k of word i becomes bit i of word k.
HANDYAR_VECTORISED void transpose(std::array<MarksOfBlocks, 32>& words) {
  std::uint32_t keep = 0x0000ffff;
  for (int by = 16; by > 0; by >>= 1, keep ^= keep << by)
    for (int i = 0; i < 32; i += 2 * by)
      for (int k = i; k < i + by; ++k) {
        MarksOfBlocks low = words[k], high = words[k + by];
        for (int block = 0; block < kBlocks; ++block) {
          const std::uint32_t swapped = (low[block] >> by ^ high[block]) & keep;
          low[block] ^= swapped << by;
          high[block] ^= swapped;
        }
        words[k] = low;
        words[k + by] = high;
      }
}

/// The part of the image that holds a hand and its surroundings.
BinView around(const BinView& image, const HandShape& hand) {
  const Eigen::AlignedBox2f box = hand.bounds();
  const int margin = static_cast<int>(hand.palm_radius());
  const int u0 = std::clamp(int(box.min().x()) - margin, 0, image.width);
  const int v0 = std::clamp(int(box.min().y()) - margin, 0, image.height);
  return image.part(u0, v0, std::clamp(int(box.max().x()) + margin, u0, image.width),
                    std::clamp(int(box.max().y()) + margin, v0, image.height));
}

/// Where a part of the image begins, in its bins.
Eigen::Vector2f origin_in(const BinView& image, const BinView& part) {
  return (part.origin_px() - image.origin_px()) / static_cast<float>(image.step_px);
}

HandShapeConfig shape_to_look_for(const HandSearchConfig& config, HandShapeConfig shape) {
  shape.max_deviation = config.max_deviation;
  return shape;
}

}  // namespace

HandSearch::HandSearch(MaskStages& stages, const HandSearchConfig& config,
                       const HandShapeConfig& shape, const HandShapeModel& model)
    : stages_(stages),
      config_(config),
      shape_config_(shape_to_look_for(config, shape)),
      shape_model_(model),
      seen_bins_(kBinCount + 1),
      coarse_(kCoarseCount),
      patch_(kCoarseCount),
      patch_smooth_(kCoarseCount),
      marks_(kBinCount),
      masks_(std::min(config.readings_per_frame + kMaxLearned, kMaxAtOnce)),
      outlines_(config.outlines),
      proposed_{},
      samples_(std::make_unique<SkinSamples>()) {}

HandSearch::~HandSearch() = default;

void HandSearch::reserve(int max_pixels, int max_side) {
  for (Mask& mask : masks_) mask.reserve(max_pixels, max_side);
  for (Mask* mask : {&scratch_mask_, &found_mask_}) mask->reserve(max_pixels, max_side);
  outlines_.reserve(max_pixels, max_side);
  expectation_.ratios.resize(max_pixels / 4 + max_side);
}

void HandSearch::reset() noexcept {
  next_ = 0;
  outlines_.reset();
}

void HandSearch::read_scene(const BinView& image, const SkinModel& skin) noexcept {
  scene_colors_.clear();
  for (int v = 0; v < image.height; ++v)
    scene_colors_.add({image.row(v), static_cast<std::size_t>(image.width)});
  seen_count_ = 0;
  std::ranges::fill(coarse_, 0.0f);
  const float share = 1 / scene_colors_.total();  // of a pixel
  const BinSmoothing smoothing;
  BinPlane scene, hand;
  for (int luma = 0; luma < kBinLevels; ++luma) {
    scene_colors_.smooth(smoothing, luma, scene);
    skin.learned_hand().smooth(smoothing, luma, hand);
    for_each_row(scene.filled, [&](int row) {
      float* const coarse_row = coarse_.data() + coarse(first_bin(luma, row));
      const float* const count = scene.rows[row].data();
      for (int k = 0; k < kCoarseLevels; ++k)
        coarse_row[k] += share * (count[2 * k] + count[2 * k + 1]);
    });
    for_each_row(scene_colors_.filled()[luma], [&](int row) {
      const int begin = first_bin(luma, row);
      for (int i = begin; i < begin + kBinLevels; ++i) {
        const auto bin = static_cast<ColorBin>(i);
        seen_bins_[seen_count_] = bin;  // no branch: there is no foreseeing it
        seen_count_ += scene_colors_[bin] != 0;
      }
      const Share of_scene{scene.rows[row].data(), share};
      compare_with_prior(skin.prior_skin().data() + begin, of_scene, scene_.data() + begin);
      // However the hand was learned: how much more of a colour it has than this frame.
      if (skin.has_learned())
        compare({hand.row(row).data(), 1 / skin.learned_hand().total()}, of_scene,
                known_.data() + begin);
    });
  }
}

void HandSearch::add_levels(const Channel& channel, int levels) noexcept {
  // Thresholds that cut the scene's distribution of this channel where it is thin (Lloyd's
  // quantiser): between its clusters.
  std::array<float, 256> histogram{};
  for (const ColorBin i : std::span(seen_bins_).first(seen_count_))
    histogram[channel[i] + 128] += scene_colors_[i];
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
    readings_[reading_count_++] = {&channel, static_cast<std::int8_t>(cut)};
    readings_[reading_count_++] = {&channel, static_cast<std::int8_t>(cut), true};
  }
}

void HandSearch::list_readings(const BinView& image, const Channel& prior) noexcept {
  reading_count_ = 0;
  const auto add = [&](const Reading& r) { readings_[reading_count_++] = r; };
  for (const std::int8_t t : {-8, 0, 8, 16}) add({&prior, t});
  for (const std::int8_t t : {-16, -12, -8, -4, 0, 8}) add({&scene_, t});
  for (const Channel* channel : {&kLuma, &kRedness, &kBlueness}) add_levels(*channel, 5);
  // Patches, the most skin-like first; the darkest hand is still likelier skin than most things.
  std::array<std::pair<float, int>, kPatchColumns * kPatchRows> patches;
  for (int p = 0; p < static_cast<int>(patches.size()); ++p) {
    const int u0 = p % kPatchColumns * image.width / kPatchColumns;
    const int v0 = p / kPatchColumns * image.height / kPatchRows;
    float sum = 0;
    for (int v = v0; v < v0 + image.height / kPatchRows; v += 4)
      for (int u = u0; u < u0 + image.width / kPatchColumns; u += 4) sum += prior[image.at(u, v)];
    patches[p] = {-sum, p};
  }
  std::ranges::sort(patches);
  for (int k = 0; k < kTriedPatches; ++k) add({nullptr, 0, false, patches[k].second});
  // Interleave, so that a frame's turn holds readings of every kind.
  constexpr int kStride = 7;
  std::array<Reading, 128> mixed;
  for (int start = 0, k = 0; start < kStride; ++start)
    for (int i = start; i < reading_count_; i += kStride) mixed[k++] = readings_[i];
  std::copy_n(mixed.begin(), reading_count_, readings_.begin());
}

/// Which coarse colours a patch has more of than the whole frame.
void HandSearch::read_patch(const BinView& image, int patch) noexcept {
  const int width = image.width / kPatchColumns, height = image.height / kPatchRows;
  const int u0 = patch % kPatchColumns * width, v0 = patch / kPatchColumns * height;
  std::ranges::fill(patch_, 0.0f);
  for (int v = v0; v < v0 + height; ++v)
    for (int u = u0; u < u0 + width; ++u) patch_[coarse(image.at(u, v))] += 1;
  // One level around each colour.
  smooth_along<1>(patch_.data(), patch_smooth_.data());
  smooth_along<kCoarseLevels>(patch_smooth_.data(), patch_.data());
  smooth_along<kCoarseLevels * kCoarseLevels>(patch_.data(), patch_smooth_.data());
  const float total = static_cast<float>(width * height);
  for (int i = 0; i < kCoarseCount; ++i)
    in_patch_[i] = patch_smooth_[i] / total > 1.5f * coarse_[i] + 1e-4f;
}

/// Bit k of a bin's mark: reading k takes its colour for the hand's.
void HandSearch::mark_bins(const BinView& image, std::span<const Reading> readings) noexcept {
  for (int luma = 0; luma < kBinLevels; ++luma)
    for_each_row(scene_colors_.filled()[luma], [&](int row) {
      std::fill_n(marks_.begin() + first_bin(luma, row), kBinLevels, 0u);
    });
  for (std::size_t k = 0; k < readings.size(); ++k) {
    const Reading& reading = readings[k];
    if (reading.patch >= 0) read_patch(image, reading.patch);
    for (int luma = 0; luma < kBinLevels; ++luma) {
      const std::uint32_t rows = scene_colors_.filled()[luma];
      const int begin = first_bin(luma, 0);
      if (reading.patch < 0) {
        mark_rows(reading.channel->data() + begin, rows, reading.below, reading.threshold,
                  static_cast<int>(k), marks_.data() + begin);
        continue;
      }
      for_each_row(rows, [&](int row) {
        std::uint32_t* const marks = marks_.data() + first_bin(luma, row);
        const bool* const in_patch = in_patch_.data() + coarse(first_bin(luma, row));
        for (int i = 0; i < kCoarseLevels; ++i) {
          const std::uint32_t mark = std::uint32_t{in_patch[i]} << k;
          marks[2 * i] |= mark;
          marks[2 * i + 1] |= mark;
        }
      });
    }
  }
}

/// The masks of all readings at once: every pixel is looked up a single time.
void HandSearch::draw_masks(const BinView& image, int count) noexcept {
  for (int k = 0; k < count; ++k) masks_[k].resize(image.width, image.height);
  for (int v = 0; v < image.height; ++v) {
    const ColorBin* bin = image.row(v);
    for (int u = 0; u < image.width; u += 32 * kBlocks) {
      std::array<MarksOfBlocks, 32> marks{};
      const int length = std::min(32 * kBlocks, image.width - u);
      for (int i = 0; i < length; ++i) marks[i & 31][i >> 5] = marks_[*bin++];
      transpose(marks);
      for (int k = 0; k < count; ++k)
        std::memcpy(masks_[k].row(v) + (u >> 6), marks[k].data(), (length + 63) / 64 * 8);
    }
  }
}

bool HandSearch::try_region(float palm_radius, HandShape& best) noexcept {
  stages_.curvature.find(stages_.contour, palm_radius);
  HandShape shape;
  if (!find_hand_shape(stages_.curvature, stages_.contour, stages_.region.mask(), palm_radius,
                       shape_model_, shape_config_, shape) ||
      shape.deviation >= best.deviation)
    return false;
  best = shape;
  return true;
}

/// Keeps the shape that one reading or outline shows of a part of the frame; true when it is more
/// like a hand than `best`, which it then is.
bool HandSearch::take(const HandShape& view, const Eigen::Vector2f& origin,
                      HandShape& best) noexcept {
  if (view_count_ < kMaxViews) views_[view_count_++] = view.transformed(1, origin);
  if (view.deviation >= best.deviation) return false;
  best = view;
  return true;
}

/// Looks at the regions of what was classified; true when one is more like a hand than `best`.
bool HandSearch::try_regions(HandShape& best) noexcept {
  HandShape view;
  view.deviation = static_cast<float>(shape_config_.max_deviation);
  stages_.region.remove_thin(1);
  const int pixels = stages_.region.mask().width * stages_.region.mask().height;
  const Component* winner = nullptr;
  for (const Component& c :
       stages_.region.components(static_cast<int>(config_.min_area_share * pixels))) {
    if (c.area > 0.7 * pixels || !stages_.contour.trace(stages_.region.mask(), c) ||
        !may_be_hand(c, stages_.contour))
      continue;
    const Disc disc = stages_.region.deepest(c);
    // The deepest point may lie in a forearm or in something that hangs together with the hand.
    for (const float scale : {1.0f, 0.6f})
      if (disc.radius * scale > kLeastPalm && try_region(disc.radius * scale, view)) winner = &c;
  }
  if (winner == nullptr || !take(view, Eigen::Vector2f::Zero(), best)) return false;
  stages_.region.keep_only(*winner);
  found_mask_.copy(stages_.region.mask());
  return true;
}

/// The region whose colours are those along the proposed hand's fingers rather than those around
/// it, wherever it reaches and then where the hand should be.
bool HandSearch::try_proposal(const BinView& image, const SkinModel& skin,
                              const HandShape& proposal, HandShape& best) noexcept {
  const BinView part = around(image, proposal);
  const Eigen::Vector2f origin = origin_in(image, part);
  const HandShape hand = proposal.transformed(1, -origin);
  sample_skin(part, nullptr, hand, *samples_);
  hand_colors_.clear();
  hand_colors_.add(samples_->hand);
  scene_colors_.clear();
  scene_colors_.add(samples_->background);
  skin.ratios_of_found(hand_colors_, scene_colors_, proposed_);
  hand.expect(part.width, part.height, expectation_);
  const int min_area = static_cast<int>(config_.min_area_share * image.width * image.height);
  HandShape view;
  view.deviation = static_cast<float>(shape_config_.max_deviation);
  bool found = false;
  for (ExpectedRegion* where : {&anywhere_, &expectation_}) {
    const Component* c = stages_.region.segment(part, proposed_, *where, hand.parts(), min_area);
    if (c == nullptr || !stages_.contour.trace(stages_.region.mask(), *c) ||
        !try_region(hand.palm_radius(), view))
      continue;
    if (view.deviation < best.deviation) found_mask_.copy(stages_.region.mask());
    found = true;
  }
  return found && take(view, origin, best);
}

bool HandSearch::find(const BinView& image, const SkinModel& skin, HandShape& shape) noexcept {
  agreeing_ = 0;
  if (!find_best(image, skin, shape)) return false;
  const HandShape in_frame = shape.transformed(1, origin_in(image, found_image_));
  for (int k = 0; k < view_count_; ++k) agreeing_ += views_[k].resembles(in_frame);
  return true;
}

/// The most hand-like region.
bool HandSearch::find_best(const BinView& image, const SkinModel& skin, HandShape& shape) noexcept {
  view_count_ = 0;
  shape.deviation = static_cast<float>(shape_config_.max_deviation);
  found_image_ = image;
  stages_.region.classify(image, skin.ratios(), anywhere_);
  found_by_skin_ = try_regions(shape);
  if (shape.deviation < shape_config_.sure_deviation) return true;

  read_scene(image, skin);
  list_readings(image, skin.prior_ratios());
  // What was learned comes first in every frame; the other readings take turns.
  std::array<Reading, kMaxAtOnce> now;
  int learned = 0;
  if (skin.has_learned())
    for (const std::int8_t t : {0, 6, 12}) now[learned++] = {&known_, t};
  const int room = static_cast<int>(masks_.size()) - learned;
  const int turns = std::min({config_.readings_per_frame, reading_count_, room});
  for (int k = 0; k < turns; ++k) now[learned + k] = readings_[(next_ + k) % reading_count_];
  next_ = (next_ + turns) % reading_count_;
  mark_bins(image, {now.data(), static_cast<std::size_t>(learned + turns)});
  draw_masks(image, learned + turns);
  for (int k = 0; k < learned; ++k) majority(masks_[k], scratch_mask_);

  bool found = found_by_skin_;
  for (int k = 0; k < learned + turns; ++k) {
    stages_.region.classify(masks_[k]);
    if (!try_regions(shape)) continue;
    found = true;
    found_by_skin_ = k < learned;
    if (shape.deviation < shape_config_.sure_deviation) return true;
  }
  const HandShape* proposed = nullptr;
  for (const HandShape& proposal : outlines_.find(image))
    if (try_proposal(image, skin, proposal, shape)) proposed = &proposal;
  if (proposed == nullptr) return found;
  found_by_skin_ = false;
  found_image_ = around(image, *proposed);
  return true;
}

}  // namespace handyar
