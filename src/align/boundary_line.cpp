// SPDX-License-Identifier: MIT
#include "align/boundary_line.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "image/fast_log.hpp"

namespace handyar {
namespace {

// Neighbouring pixels are of one colour for other reasons than the hand: so much of a segment's
// ratio is new.
constexpr float kRatioWeight = 0.3f;
// A step in luma of this many levels doubles how likely a boundary is there.
constexpr float kCalmStep = 8.0f;
constexpr float kLeastVariance = 1.0f / 12;  // segments squared: it may lie anywhere in one
constexpr float kFarAway_px = 1e3f;          // so little is known of a boundary that is not seen

/// Pixels of a line, from inside to outside.
struct LinePixels {
  std::array<std::int32_t, PixelGroup::kMost> x, y, seen;  ///< seen: 1 or 0
};

/// In vectors; all that matters to it lies in its arguments.
HANDYAR_VECTORISED void place_pixels(const PixelReader& reader, const Eigen::Vector2f& from,
                                     const Eigen::Vector2f& step, float segment_px, int half,
                                     int reads, float inside_px, float outside_px,
                                     LinePixels& out) noexcept {
  const float per_segment = 1.0f / static_cast<float>(reads);
  const int count = 2 * half * reads;
  for (int i = 0; i < PixelGroup::kMost; ++i) {
    const float r =
        segment_px * ((static_cast<float>(i) + 0.5f) * per_segment - static_cast<float>(half));
    const float x = from.x() + r * step.x(), y = from.y() + r * step.y();
    out.seen[i] = (i < count) & (-r <= inside_px) & (r <= outside_px) & reader.covers(x, y);
    out.x[i] = reader.nearest_x(x), out.y[i] = reader.nearest_y(y);
  }
}

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
  LinePixels pixels;
  place_pixels(reader_, from_, step_, segment_px_, kHalf, reads, inside_px_, outside_px_, pixels);
  int count = 0;
  for (int j = 0, i = 0; j < kSegments; ++j) {
    const int before = count;
    for (int k = 0; k < reads; ++k, ++i)
      if (pixels.seen[i] != 0) reader_.read(pixels.x[i], pixels.y[i], count++, group);
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
  constexpr std::array<float, 3> share{0, 1, 0.5f};  // of a segment's mean, by its reads
  for (int j = 0, i = 0; j < kSegments; ++j)
    for (int k = 0; k < s.reads[j]; ++k, ++i) {
      s.ratio[j] += share[s.reads[j]] * ratios[i];
      s.luma[j] += share[s.reads[j]] * luma[i];
    }
  return s;
}

Boundary BoundaryLine::boundary(const Places& p, int seen) const noexcept {
  float total = 0, first = 0, second = 0;
  for (int k = 0; k < kPlaces; ++k) {
    const float x = static_cast<float>(k + 1 - kHalf);
    total += p[k];
    first += p[k] * x;
    second += p[k] * x * x;
  }
  constexpr int kHere = kHalf - 1;
  const float here = 0.25f * p[kHere - 1] + 0.5f * p[kHere] + 0.25f * p[kHere + 1];
  const float mean = first / total;
  const float variance = std::max(second / total - mean * mean, kLeastVariance);
  return {mean * segment_px_, std::sqrt(variance) * segment_px_,
          std::clamp(std::log(seen * here / total), -kMostEvidence, kMostEvidence)};
}

Boundary BoundaryLine::find(const OutlineColors& colors, int part, bool edges) const noexcept {
  const Segments s = segments(colors, part);
  // A boundary between two segments: all within are of the hand, all beyond of the background.
  Places log_p{};
  float sum = s.ratio[0];
  for (int k = 0; k < kPlaces; ++k) {
    log_p[k] = kRatioWeight * sum;
    sum += s.ratio[k + 1];
  }
  if (edges) {
    Places step{};
    for (int k = 0; k < kPlaces; ++k)
      if (s.reads[k] > 0 && s.reads[k + 1] > 0) step[k] = std::abs(s.luma[k + 1] - s.luma[k]);
    for (std::size_t k = 0; k < step.size(); ++k) log_p[k] += fast_log(kCalmStep + step[k]);
  }
  const float best = *std::max_element(log_p.begin(), log_p.begin() + kPlaces);
  Places p;
  for (int k = 0; k < kPlaces; ++k) p[k] = std::exp(log_p[k] - best);
  return boundary(p, kPlaces);
}

Boundary BoundaryLine::find_furrow(const OutlineColors& colors, int part) const noexcept {
  const Segments s = segments(colors, part);
  const auto seen = [&](int j) { return j >= 0 && j < kSegments && s.reads[j] > 0; };
  Places p{};
  int places = 0;
  for (int k = 0; k < kPlaces; ++k) {
    if (!seen(k) || !seen(k + 1)) continue;
    float depth = 0;
    if (seen(k - 1) && seen(k + 2))
      depth = std::max(0.0f,
                       std::min(s.luma[k - 1], s.luma[k + 2]) - std::min(s.luma[k], s.luma[k + 1]));
    p[k] = (kCalmStep + depth) * (kCalmStep + depth);  // a step down and one up
    ++places;
  }
  if (places == 0) return {0, kFarAway_px, 0};  // the frame ends there
  return boundary(p, places);
}

}  // namespace handyar
