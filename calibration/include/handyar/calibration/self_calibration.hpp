// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>

#include "handyar/calibration/error.hpp"
#include "handyar/calibration/view.hpp"

namespace handyar {

/// A length of the hand that a person can measure with a ruler; without one, the average adult's.
struct KnownLength {
  std::optional<double> span_m = {};  ///< thumb tip to little fingertip, fingers spread as shown
  std::optional<double> hand_length_m =
      {};  ///< crease of the wrist to the tip of the middle finger
};

struct SelfCalibration {
  HandModel hand;         ///< shape from the views; size from the known length or the average adult
  double turned_rad = 0;  ///< largest angle between the directions the hand was seen from
  int views = 0;          ///< in which the hand was tracked
};

/// Shape of a hand from its own motion, no board: the figure that the tracker has learned over the
/// views, given its size. Throws CalibrationError when it cannot be trusted: too few views or
/// directions, or a shape that the second half of the views went on to change.
SelfCalibration self_calibrate_hand(std::span<const CalibrationView> views, const Camera& camera,
                                    const KnownLength& known = {});

}  // namespace handyar
