// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>

#include "handyar/hand_model.hpp"
#include "paper/fingertips.hpp"

namespace handyar::paper {

/// The five fingertips of a hand, thumb to little, and on which side the thumb is.
struct OrderedTips {
  std::array<Eigen::Vector2f, kFingerCount> at;
  Layout layout = Layout::thumb_right;
};

/// Which fingertip is which at first (paper 2.3): the thumb is the one farthest from the tips' mean
/// at an end of the fan they form. Empty unless there are five.
std::optional<OrderedTips> order_tips(std::span<const Fingertip> tips,
                                      const Eigen::Vector2f& palm) noexcept;

/// For each finger the candidate it went to, or -1: least sum of squared displacements under the
/// contour's order (paper 2.3, equation 2). Farther than `gate` is not matched.
using TipAssignment = std::array<int, kFingerCount>;
TipAssignment match_tips(const OrderedTips& previous, std::span<const Fingertip> candidates,
                         float gate) noexcept;

}  // namespace handyar::paper
