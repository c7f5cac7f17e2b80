// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "handyar/calibration/error.hpp"
#include "handyar/calibration/hand_frame.hpp"
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
  std::vector<int> views_used;  ///< indices into the views given
};

/// Shape of a stiff hand from a moving view alone, no board: fingertips (and valleys where seen)
/// and the poses of the chosen views are adjusted together (bundle adjustment), starting from the
/// average adult hand, whose shape is kept as a weak prior (20 mm in the plane, 5 mm in height).
/// Throws CalibrationError when the views cannot carry it.
SelfCalibration self_calibrate_hand(std::span<const CalibrationView> views, const Camera& camera,
                                    const KnownLength& known = {});

}  // namespace handyar
