// SPDX-License-Identifier: MIT
#include "handyar/stages/hand_finder.hpp"

#include <algorithm>
#include <cmath>

#include "find/constellation.hpp"
#include "find/face_network.hpp"
#include "find/network.hpp"
#include "find/samples.hpp"

namespace handyar {
namespace {

using Network = FinderNetwork;

// The second look takes in so many spans around the hand.
constexpr float kSecondLook = 2.6f;

SampleGrid grid_of(const FinderRegion& region) {
  const float sample_px = region.width_px / Network::kWidth;
  return {Network::kWidth, Network::kHeight, region.to_frame({0.5f, 0.5f}, Network::kWidth),
          sample_px * Eigen::Vector2f(-region.up.y(), region.up.x()), -sample_px * region.up};
}

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

void HandFinder::Impl::look(const ImageView& frame, const FinderRegion& region) noexcept {
  take_samples(frame, grid_of(region), workspace.beside);
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

std::span<const HandCandidate> HandFinder::search(
    const ImageView& frame, const std::optional<FinderRegion>& lost_in) noexcept {
  Impl& finder = *impl_;
  finder.candidates.clear();
  if (lost_in) finder.look(frame, *lost_in);
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
