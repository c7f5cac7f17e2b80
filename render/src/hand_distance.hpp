// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "handyar/tracker.hpp"

namespace handyar::render {

/// Pixels from the hand to a point of the frame, 0 on the hand; infinite without a hand.
double distance_px(const HandMask& mask, const Eigen::Vector2d& px);

}  // namespace handyar::render
