// SPDX-License-Identifier: MIT
#include "handyar/stages/hand_finder.hpp"

#include <algorithm>
#include <cmath>

#include "find/network.hpp"
#include "image/pixel_reader.hpp"

namespace handyar {
namespace {

using Network = FinderNetwork;

constexpr int kMostCandidates = 4;
// A palm whose log odds are less is no candidate.
constexpr float kLeastOdds = -2.5f;
// Of one sample at most so many pixels a side are read: in large frames every second or third.
constexpr int kMostReads = 4;
// Two palms nearer than this share of a span are one hand.
constexpr float kSameHand = 0.35f;
// A fingertip's own map moves it by at most this share of the span from where the palm expects it.
constexpr float kReach = 0.22f;
// The second look takes in so many spans around the hand.
constexpr float kSecondLook = 2.6f;
// Candidates less likely than this are not looked at again.
constexpr float kWorthALook = -4.0f;

float sigmoid(float x) { return 1 / (1 + std::exp(-x)); }

/// Maps of a run of the network, cell by cell.
class Maps {
 public:
  explicit Maps(std::span<const float> numbers) : numbers_(numbers) {}

  bool covers(int x, int y) const {
    return x >= 0 && y >= 0 && x < Network::kCellsX && y < Network::kCellsY;
  }
  float at(int map, int x, int y) const {
    return numbers_[(y * Network::kCellsX + x) * Network::kOutputs + map];
  }

  /// The largest of a cell and its neighbours; of equals the first.
  bool peaks(int map, int x, int y) const {
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        if (!covers(x + dx, y + dy)) continue;
        const float other = at(map, x + dx, y + dy), here = at(map, x, y);
        const bool before = dy < 0 || (dy == 0 && dx < 0);
        if (before ? other >= here : other > here) return false;
      }
    return true;
  }

  /// The middle of a peak between its cells.
  Eigen::Vector2f centre(int map, int x, int y) const {
    Eigen::Vector2f sum = Eigen::Vector2f::Zero();
    float total = 0;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        if (!covers(x + dx, y + dy)) continue;
        const float weight = sigmoid(at(map, x + dx, y + dy));
        sum += weight * Eigen::Vector2f(dx, dy);
        total += weight;
      }
    return Eigen::Vector2f(x, y) + sum / std::max(total, 1e-6f);
  }

 private:
  std::span<const float> numbers_;
};

/// A fingertip by its own map, near where the palm expects it.
void refine_tip(const Maps& maps, int finger, float reach, HandCandidate& hand) {
  const int map = Network::kTips + finger;
  const Eigen::Vector2f expected = hand.tips_px[finger];
  const auto from = [&](float v) { return static_cast<int>(std::floor(v - reach)); };
  const auto to = [&](float v) { return static_cast<int>(std::ceil(v + reach)); };
  float best = 0;
  int best_x = -1, best_y = -1;
  for (int y = from(expected.y()); y <= to(expected.y()); ++y)
    for (int x = from(expected.x()); x <= to(expected.x()); ++x) {
      if (!maps.covers(x, y)) continue;
      const float off = (Eigen::Vector2f(x, y) - expected).norm() / reach;
      const float support = sigmoid(maps.at(map, x, y)) * std::max(0.0f, 1 - 0.5f * off * off);
      if (off > 1.5f || support <= best) continue;
      best = support;
      best_x = x;
      best_y = y;
    }
  hand.tip_confidence[finger] = best;
  constexpr float kSure = 0.15f;
  if (best > kSure) hand.tips_px[finger] = maps.centre(map, best_x, best_y);
}

/// The candidate of a palm, in cells.
HandCandidate read_candidate(const Maps& maps, int palm, int x, int y) {
  HandCandidate hand;
  hand.layout = palm == 0 ? Layout::thumb_right : Layout::thumb_left;
  hand.palm_px = maps.centre(palm, x, y);
  for (int f = 0; f < kFingerCount; ++f) {
    const Eigen::Vector2f offset(maps.at(Network::kOffsets + 2 * f, x, y),
                                 maps.at(Network::kOffsets + 2 * f + 1, x, y));
    hand.tips_px[f] = Eigen::Vector2f(x, y) + Network::kOffsetUnit * offset;
  }
  const float reach = std::max(1.5f, kReach * hand.span_px());
  float confidence = 0;
  for (int f = 0; f < kFingerCount; ++f) {
    refine_tip(maps, f, reach, hand);
    confidence += hand.tip_confidence[f] / kFingerCount;
  }
  hand.log_odds = Network::log_odds(maps.at(palm, x, y), confidence);
  return hand;
}

}  // namespace

struct HandFinder::Impl {
  Network network;
  std::array<HandCandidate, kMostCandidates> candidates;
  int count = 0;
  int turn = 0;  ///< of the parts, which one is next

  void sample(const ImageView& frame, const FinderRegion& region) noexcept;
  void offer(const HandCandidate& hand) noexcept;
  void look(const ImageView& frame, const FinderRegion& region) noexcept;
};

HandFinder::HandFinder() : impl_(std::make_unique<Impl>()) {}
HandFinder::~HandFinder() = default;
HandFinder::HandFinder(HandFinder&&) noexcept = default;
HandFinder& HandFinder::operator=(HandFinder&&) noexcept = default;

void HandFinder::reset() noexcept {
  impl_->count = 0;
  impl_->turn = 0;
}

/// Means over the pixels of each sample; beyond the frame grey.
void HandFinder::Impl::sample(const ImageView& frame, const FinderRegion& region) noexcept {
  const PixelReader reader(frame);
  const float scale = region.width_px / Network::kWidth;
  const Eigen::Vector2f first =
      region.centre_px - 0.5f * scale * Eigen::Vector2f(Network::kWidth, Network::kHeight);
  const int reads = std::clamp(static_cast<int>(std::lround(scale)), 1, kMostReads);
  std::array<int, Network::kWidth * kMostReads> columns;
  for (int i = 0; i < Network::kWidth * reads; ++i)
    columns[i] = static_cast<int>(std::floor(first.x() + scale * (i + 0.5f) / reads + 0.5f));
  float* out = network.input().data();
  for (int v = 0; v < Network::kHeight; ++v)
    for (int u = 0; u < Network::kWidth; ++u, out += 3) {
      std::array<int, 3> sum{};
      int within = 0;
      for (int j = 0; j < reads; ++j) {
        const int y =
            static_cast<int>(std::floor(first.y() + scale * (v + (j + 0.5f) / reads) + 0.5f));
        if (y < 0 || y >= frame.height_px) continue;
        for (int i = 0; i < reads; ++i) {
          const int x = columns[u * reads + i];
          if (x < 0 || x >= frame.width_px) continue;
          const std::array<int, 3> rgb = reader.rgb(x, y);
          for (int c = 0; c < 3; ++c) sum[c] += rgb[c];
          ++within;
        }
      }
      constexpr float kGrey = 127.5f;
      for (int c = 0; c < 3; ++c) out[c] = within > 0 ? static_cast<float>(sum[c]) / within : kGrey;
    }
}

/// Keeps the likeliest, each hand once.
void HandFinder::Impl::offer(const HandCandidate& hand) noexcept {
  for (int i = 0; i < count; ++i) {
    HandCandidate& known = candidates[i];
    const float span = std::max(known.span_px(), hand.span_px());
    if (known.layout != hand.layout || (known.palm_px - hand.palm_px).norm() > kSameHand * span)
      continue;
    if (hand.log_odds > known.log_odds) known = hand;
    return;
  }
  if (count < kMostCandidates) {
    candidates[count++] = hand;
  } else {
    auto worst = std::min_element(candidates.begin(), candidates.end(),
                                  [](auto& a, auto& b) { return a.log_odds < b.log_odds; });
    if (worst->log_odds < hand.log_odds) *worst = hand;
  }
}

void HandFinder::Impl::look(const ImageView& frame, const FinderRegion& region) noexcept {
  sample(frame, region);
  const Maps maps(network.run());
  const float cell_px = region.width_px / Network::kCellsX;
  const Eigen::Vector2f first =
      region.centre_px - 0.5f * cell_px * Eigen::Vector2f(Network::kCellsX, Network::kCellsY);
  const auto to_frame = [&](const Eigen::Vector2f& cells) -> Eigen::Vector2f {
    return first + cell_px * (cells + Eigen::Vector2f::Constant(0.5f));
  };
  for (int palm = 0; palm < 2; ++palm)
    for (int y = 0; y < Network::kCellsY; ++y)
      for (int x = 0; x < Network::kCellsX; ++x) {
        if (maps.at(palm, x, y) < kLeastOdds || !maps.peaks(palm, x, y)) continue;
        HandCandidate hand = read_candidate(maps, palm, x, y);
        hand.palm_px = to_frame(hand.palm_px);
        for (Eigen::Vector2f& tip : hand.tips_px) tip = to_frame(tip);
        offer(hand);
      }
  std::sort(candidates.begin(), candidates.begin() + count,
            [](const auto& a, const auto& b) { return a.log_odds > b.log_odds; });
}

std::span<const HandCandidate> HandFinder::look(const ImageView& frame,
                                                const FinderRegion& region) noexcept {
  impl_->count = 0;
  impl_->look(frame, region);
  return {impl_->candidates.data(), static_cast<std::size_t>(impl_->count)};
}

std::span<const HandCandidate> HandFinder::search(const ImageView& frame) noexcept {
  Impl& finder = *impl_;
  finder.count = 0;
  const Eigen::Vector2f size(static_cast<float>(frame.width_px),
                             static_cast<float>(frame.height_px));
  const Eigen::Vector2f middle = 0.5f * size - Eigen::Vector2f::Constant(0.5f);
  const float whole = std::max(size.x(), size.y() * 4 / 3);
  // The whole and, for small hands, a part of half its size in turn: the middle and around it.
  constexpr std::array<std::array<float, 2>, 5> kParts{
      {{0, 0}, {-0.25f, -0.25f}, {0.25f, -0.25f}, {-0.25f, 0.25f}, {0.25f, 0.25f}}};
  if (finder.turn % 2 == 0) {
    finder.look(frame, {middle, whole});
  } else {
    const auto& part = kParts[static_cast<std::size_t>(finder.turn / 2) % kParts.size()];
    const Eigen::Vector2f off = Eigen::Vector2f(part[0], part[1]).cwiseProduct(size);
    finder.look(frame, {middle + off, 0.5f * whole});
  }
  const HandCandidate best = finder.candidates[0];
  if (finder.count > 0 && best.log_odds > kWorthALook) {
    Eigen::Vector2f around = best.palm_px;
    for (const Eigen::Vector2f& tip : best.tips_px) around += tip;
    finder.look(frame, {around / (1 + kFingerCount), kSecondLook * best.span_px()});
  }
  // Where a hand is likely the next frame is searched in the same way.
  if (finder.count == 0 || finder.candidates[0].log_odds < 0) ++finder.turn;
  return {finder.candidates.data(), static_cast<std::size_t>(finder.count)};
}

}  // namespace handyar
