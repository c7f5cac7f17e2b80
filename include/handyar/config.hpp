// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "handyar/hand_model.hpp"

namespace handyar {

/// What a person would turn. How large the frames are is not among it: the tracker looks at places
/// along the outline, so large frames take hardly longer.
struct Config {
  /// The hand that will be shown, where it is known: it tells palm from back. Empty: either.
  std::optional<Side> side;

  /// 1: as designed; larger: smoother, and later when the hand speeds up; 0: the pose of each frame
  /// as it is; less than 0.001 else counts as that. Divides the accelerations of PoseFilterConfig.
  double smoothing = 1.0;

  /// Clock for StageTimes, in seconds; null: times stay zero. Nothing else depends on it.
  double (*now_s)() = nullptr;
};

}  // namespace handyar
