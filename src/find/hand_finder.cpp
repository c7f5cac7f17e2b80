// SPDX-License-Identifier: MIT
#include "handyar/stages/hand_finder.hpp"

#include <algorithm>
#include <cmath>

#include "find/constellation.hpp"
#include "find/face_network.hpp"
#include "find/network.hpp"
#include "image/pixel_reader.hpp"

namespace handyar {
namespace {

using Network = FinderNetwork;

// Of one sample at most so many pixels a side are read: in large frames every second or third.
constexpr int kMostReads = 4;
// The second look takes in so many spans around the hand.
constexpr float kSecondLook = 2.6f;
// Fingertips that are nearer than this share of a hand's reach are the same.
constexpr float kSameTips = 0.25f;

}  // namespace

float HandPlace::reach_px() const noexcept {
  float reach_px = 0;
  for (const Eigen::Vector2f& tip_px : tips_px)
    reach_px = std::max(reach_px, (tip_px - palm_px).norm());
  return reach_px;
}

bool HandPlace::same_tips(const HandPlace& other) const noexcept {
  const float near_px = kSameTips * other.reach_px();
  for (int f = 0; f < kFingerCount; ++f)
    if ((tips_px[f] - other.tips_px[f]).norm() > near_px) return false;
  return true;
}

FinderRegion HandPlace::region(float width_px) const noexcept {
  Eigen::Vector2f around_px = palm_px;
  for (const Eigen::Vector2f& tip_px : tips_px) around_px += tip_px;
  return {around_px / (1 + kFingerCount), width_px};
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
  const float scale = region.width_px / Network::kWidth;
  const Eigen::Vector2f first =
      region.centre_px - 0.5f * scale * Eigen::Vector2f(Network::kWidth, Network::kHeight);
  const int reads = std::clamp(static_cast<int>(std::lround(scale)), 1, kMostReads);
  std::array<int, Network::kWidth * kMostReads> columns;
  for (int i = 0; i < Network::kWidth * reads; ++i)
    columns[i] = static_cast<int>(std::floor(first.x() + scale * (i + 0.5f) / reads + 0.5f));
  float* out = workspace.beside.data();
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

void HandFinder::Impl::look(const ImageView& frame, const FinderRegion& region) noexcept {
  sample(frame, region);
  HandCandidates there;
  read_constellations(FinderMaps(network.run(workspace)), there);
  const float cell_px = region.width_px / Network::kCellsX;
  const Eigen::Vector2f first =
      region.centre_px - 0.5f * cell_px * Eigen::Vector2f(Network::kCellsX, Network::kCellsY);
  const auto to_frame = [&](const Eigen::Vector2f& cells) -> Eigen::Vector2f {
    return first + cell_px * (cells + Eigen::Vector2f::Constant(0.5f));
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
