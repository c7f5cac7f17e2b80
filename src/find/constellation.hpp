// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "find/finder_maps.hpp"
#include "handyar/stages/hand_finder.hpp"

namespace handyar {

/// The likeliest hands, each once.
class HandCandidates {
 public:
  static constexpr int kMost = 4;

  void clear() noexcept { count_ = 0; }
  /// Keeps a hand if it is likelier than what is known there, or than the least likely.
  void offer(const HandCandidate& hand) noexcept;
  /// The likeliest first.
  void sort() noexcept;
  std::span<const HandCandidate> items() const noexcept {
    return {items_.data(), static_cast<std::size_t>(count_)};
  }
  std::span<HandCandidate> items() noexcept {
    return {items_.data(), static_cast<std::size_t>(count_)};
  }

 private:
  std::array<HandCandidate, kMost> items_;
  int count_ = 0;
};

/// The hands that the peaks of the fingertips' maps can be, in cells: of all choices of a peak for
/// each finger, at most one of them missing, those that are likeliest by the peaks themselves, by
/// how fingertips of a hand lie to each other, and by the palm's map where its palm then is.
void read_constellations(const FinderMaps& maps, HandCandidates& hands) noexcept;

}  // namespace handyar
