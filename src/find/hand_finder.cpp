// SPDX-License-Identifier: MIT
#include "handyar/stages/hand_finder.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "find/constellation.hpp"
#include "find/face_network.hpp"
#include "find/network.hpp"
#include "image/pixel_reader.hpp"

namespace handyar {
namespace {

using Network = FinderNetwork;

// Of one sample at most so many pixels a side are read: of large frames not all.
constexpr int kMostReads = 4;
// The second look takes in so many spans around the hand.
constexpr float kSecondLook = 2.6f;

}  // namespace

float HandPlace::reach_px() const noexcept {
  float reach_px = 0;
  for (const Eigen::Vector2f& tip_px : tips_px)
    reach_px = std::max(reach_px, (tip_px - palm_px).norm());
  return reach_px;
}

FinderRegion HandPlace::region(float width_px) const noexcept {
  Eigen::Vector2f around_px = palm_px, up = Eigen::Vector2f::Zero();
  for (const Eigen::Vector2f& tip_px : tips_px) around_px += tip_px;
  for (int f = 1; f < kFingerCount; ++f) up += tips_px[f] - palm_px;
  const bool upright = std::abs(up.y()) >= std::abs(up.x());
  (upright ? up.x() : up.y()) = 0;
  return {around_px / (1 + kFingerCount), width_px, up.normalized()};
}

struct HandFinder::Impl {
  Network network;
  FaceNetwork faces;
  layers::Workspace workspace;
  HandCandidates candidates;
  int turn = 0;  ///< of the parts, which one is next

  void sample(const ImageView& frame, const FinderRegion& region) noexcept;
  void look(const ImageView& frame, const FinderRegion& region) noexcept;
  void tell_faces(const ImageView& frame) noexcept;
};

HandFinder::HandFinder() : impl_(std::make_unique<Impl>()) {}
HandFinder::~HandFinder() = default;
HandFinder::HandFinder(HandFinder&&) noexcept = default;
HandFinder& HandFinder::operator=(HandFinder&&) noexcept = default;

void HandFinder::reset() noexcept {
  impl_->candidates.clear();
  impl_->turn = 0;
}

/// Means over the pixels of each sample; beyond the frame grey.
void HandFinder::Impl::sample(const ImageView& frame, const FinderRegion& region) noexcept {
  const PixelReader reader(frame);
  const int reads =
      std::clamp(static_cast<int>(std::lround(region.width_px / Network::kWidth)), 1, kMostReads);
  // Where a read lies is the sum of where its column and its row begin, in parts of a pixel.
  constexpr int kParts = 16;  // bits
  using Place = std::array<std::int64_t, 2>;
  const auto across = static_cast<float>(Network::kWidth * reads);
  const auto in_parts = [](const Eigen::Vector2f& px) {
    return Place{std::llround(std::ldexp(px.x(), kParts)),
                 std::llround(std::ldexp(px.y(), kParts))};
  };
  const Eigen::Vector2f first_px = region.to_frame({0.5f, 0.5f}, across);
  std::array<Place, Network::kWidth * kMostReads> columns;
  std::array<Place, Network::kHeight * kMostReads> rows;
  for (int i = 0; i < Network::kWidth * reads; ++i)
    columns[i] = in_parts(region.to_frame({i + 0.5f, 0.5f}, across) + Eigen::Vector2f(0.5f, 0.5f));
  for (int j = 0; j < Network::kHeight * reads; ++j)
    rows[j] = in_parts(region.to_frame({0.5f, j + 0.5f}, across) - first_px);
  float* out = workspace.beside.data();
  for (int v = 0; v < Network::kHeight; ++v)
    for (int u = 0; u < Network::kWidth; ++u, out += 3) {
      std::array<int, 3> sum{};
      int within = 0;
      for (int j = v * reads; j < (v + 1) * reads; ++j)
        for (int i = u * reads; i < (u + 1) * reads; ++i) {
          const std::int64_t x = (columns[i][0] + rows[j][0]) >> kParts,
                             y = (columns[i][1] + rows[j][1]) >> kParts;
          if (x < 0 || y < 0 || x >= frame.width_px || y >= frame.height_px) continue;
          const std::array<int, 3> rgb = reader.rgb(static_cast<int>(x), static_cast<int>(y));
          for (int c = 0; c < 3; ++c) sum[c] += rgb[c];
          ++within;
        }
      constexpr float kGrey = 127.5f;
      for (int c = 0; c < 3; ++c) out[c] = within > 0 ? static_cast<float>(sum[c]) / within : kGrey;
    }
}

void HandFinder::Impl::look(const ImageView& frame, const FinderRegion& region) noexcept {
  sample(frame, region);
  HandCandidates there;
  read_constellations(FinderMaps(network.run(workspace)), there);
  const auto to_frame = [&](const Eigen::Vector2f& cells) {
    return region.to_frame(cells + Eigen::Vector2f::Constant(0.5f), Network::kCellsX);
  };
  for (HandCandidate hand : there.items()) {
    hand.palm_px = to_frame(hand.palm_px);
    for (Eigen::Vector2f& tip : hand.tips_px) tip = to_frame(tip);
    candidates.offer(hand);
  }
  candidates.sort();
}

void HandFinder::Impl::tell_faces(const ImageView& frame) noexcept {
  for (HandCandidate& hand : candidates.items()) {
    const FaceNetwork::Look look = faces.look(frame, hand, hand.layout, workspace);
    hand.palm_log_odds = look.palm_log_odds;
    hand.roots_px = look.roots_px;
  }
}

std::span<const HandCandidate> HandFinder::look(const ImageView& frame,
                                                const FinderRegion& region) noexcept {
  impl_->candidates.clear();
  impl_->look(frame, region);
  impl_->tell_faces(frame);
  return impl_->candidates.items();
}

std::span<const HandCandidate> HandFinder::search(const ImageView& frame) noexcept {
  Impl& finder = *impl_;
  finder.candidates.clear();
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
  if (const auto found = finder.candidates.items(); !found.empty())
    finder.look(frame, found[0].region(kSecondLook * found[0].span_px()));
  finder.tell_faces(frame);
  const auto found = finder.candidates.items();
  // Where a hand is likely the next frame is searched in the same way.
  if (found.empty() || found[0].log_odds < 0) ++finder.turn;
  return found;
}

}  // namespace handyar
