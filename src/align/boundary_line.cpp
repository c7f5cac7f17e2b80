// SPDX-License-Identifier: MIT
#include "align/boundary_line.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "image/fast_log.hpp"

namespace handyar {
namespace {

// Neighbouring pixels are of one colour for other reasons than the hand: so much of a segment's
// ratio is new.
constexpr float kRatioWeight = 0.3f;
// A step in luma of this many levels doubles how likely a boundary is there.
constexpr float kCalmStep = 8.0f;
constexpr float kLeastVariance = 0.1f;  // segments squared: no boundary is seen better
constexpr float kMostEvidence = 3.0f;   // of one line, nats: a line may be wrong altogether

}  // namespace

BoundaryLine::BoundaryLine(const PixelReader& reader, const HandView& view,
                           const OutlinePlace& place, float segment_px, float inside_px,
                           float outside_px) noexcept
    : reader_(reader),
      from_(view.to_frame(place.px)),
      segment_px_(segment_px),
      inside_px_(inside_px),
      outside_px_(outside_px) {
  constexpr float kFar = 8;
  step_ = (view.to_frame(place.px + kFar * place.normal) - from_) / kFar;
}

/// Pixels from inside to outside, and how many there are of each segment; returns of all.
int BoundaryLine::read(Segments& segments, PixelGroup& group) const noexcept {
  const int reads = segment_px_ < 1.5f ? 1 : 2;
  int count = 0;
  for (int j = 0; j < kSegments; ++j) {
    const int before = count;
    for (int k = 0; k < reads; ++k) {
      const float r = segment_px_ * (j - kHalf + (k + 0.5f) / reads);
      if (-r > inside_px_ || r > outside_px_) continue;
      if (const auto p = pixel(r)) reader_.read(p->x(), p->y(), count++, group);
    }
    segments.reads[j] = count - before;
  }
  return count;
}

BoundaryLine::Segments BoundaryLine::segments(const OutlineColors& colors,
                                              int part) const noexcept {
  Segments s;
  PixelGroup group;
  const auto count = static_cast<std::size_t>(read(s, group));
  std::array<ColorBin, PixelGroup::kMost> bins;
  PixelGroup::Numbers luma;
  reader_.tell(group, bins, luma);
  std::array<float, PixelGroup::kMost> ratios{};
  colors.log_ratios(part, {bins.data(), count}, ratios);
  for (int j = 0, i = 0; j < kSegments; ++j)
    for (int k = 0; k < s.reads[j]; ++k, ++i) {
      s.ratio[j] += ratios[i] / s.reads[j];
      s.luma[j] += luma[i];
    }
  for (int j = 0; j < kSegments; ++j)
    if (s.reads[j] > 0) s.luma[j] /= s.reads[j];
  return s;
}

Boundary BoundaryLine::find(const OutlineColors& colors, int part, bool edges) const noexcept {
  const Segments s = segments(colors, part);
  // A boundary between two segments: all within are of the hand, all beyond of the background.
  std::array<float, kPlaces> log_p;
  float sum = s.ratio[0], best = -1e9f;
  for (int k = 0; k < kPlaces; ++k) {
    log_p[k] = kRatioWeight * sum;
    if (edges && s.reads[k] > 0 && s.reads[k + 1] > 0)
      log_p[k] += fast_log(kCalmStep + std::abs(s.luma[k + 1] - s.luma[k]));
    else if (edges)
      log_p[k] += fast_log(kCalmStep);
    sum += s.ratio[k + 1];
    best = std::max(best, log_p[k]);
  }
  float total = 0, first = 0, second = 0, here = 0;
  for (int k = 0; k < kPlaces; ++k) {
    const float p = std::exp(log_p[k] - best), x = k + 1 - kHalf;
    total += p;
    first += p * x;
    second += p * x * x;
    if (std::abs(x) <= 1) here += x == 0 ? 0.5f * p : 0.25f * p;
  }
  const float mean = first / total;
  const float variance = std::max(second / total - mean * mean, kLeastVariance);
  return {mean * segment_px_, std::sqrt(variance) * segment_px_,
          std::clamp(std::log(kPlaces * here / total + 1e-6f), -kMostEvidence, kMostEvidence)};
}

}  // namespace handyar
