// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "handyar/camera.hpp"
#include "handyar/stages/align.hpp"
#include "handyar/stages/hand_finder.hpp"

namespace handyar {

/// A candidate's fingertips and roots, which err by some hundredths of its span.
RoughFingers rough_fingers(const HandCandidate& candidate) noexcept;

/// Fingertips and the fingers' roots where a finder saw them, as places of the hand: they go along
/// with it until the finder looks again.
struct SeenFingers {
  Eigen::Matrix<double, 3, kFingerCount> tips_m, roots_m;
  RoughFingers then;  ///< as they were seen

  /// Where they are in a frame in which the hand has another pose; empty where part of it is not
  /// before the camera. Farther from where they were seen they are less sure: a hand that moves
  /// bends its fingers, too.
  std::optional<RoughFingers> in_frame(const Eigen::Isometry3d& T_camera_hand,
                                       const Camera& camera) const noexcept;
};

/// What was seen of a hand that is laid on the same frame: as far away as its figure is there.
SeenFingers on_hand(const RoughFingers& seen, Appearance appearance, const HandState& state,
                    const Camera& camera) noexcept;

}  // namespace handyar
