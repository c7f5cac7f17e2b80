// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <complex>
#include <vector>

#include "find/layers.hpp"
#include "handyar/image_view.hpp"
#include "handyar/stages/hand_finder.hpp"

namespace handyar {

/// Tells palm from back, and where the fingers have their roots, as tools/finder/face.py has it: a
/// small network looks at the hand, turned upright and scaled by its fingertips, thumb right. All
/// machines give the same bits.
class FaceNetwork {
 public:
  FaceNetwork();

  struct Look {
    float palm_log_odds;  ///< towards the camera, against the back
    std::array<Eigen::Vector2f, kFingerCount> roots_px;
  };
  /// Looks at an open hand.
  Look look(const ImageView& frame, const HandPlace& hand, Layout layout,
            layers::Workspace& in) const noexcept;

 private:
  static constexpr int kOutputs = 1 + 2 * kFingerCount;
  std::array<float, kOutputs> run(layers::Workspace& in) const noexcept;

  std::array<std::complex<float>, kFingerCount> average_tips_m_;
  std::vector<float> weights_;
};

}  // namespace handyar
