// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <complex>
#include <vector>

#include "find/layers.hpp"
#include "handyar/image_view.hpp"
#include "handyar/stages/hand_finder.hpp"

namespace handyar {

/// Tells palm from back as tools/finder/face.py has it: a small network looks at the hand, turned
/// upright and scaled by its fingertips, thumb right. All machines give the same bits.
class FaceNetwork {
 public:
  FaceNetwork();

  /// Log odds of the palm towards the camera against the back, of an open hand there.
  float palm_log_odds(const ImageView& frame, const HandPlace& hand, Layout layout,
                      layers::Workspace& in) const noexcept;

 private:
  float run(layers::Workspace& in) const noexcept;

  std::array<std::complex<float>, kFingerCount> average_tips_m_;
  std::vector<float> weights_;
};

}  // namespace handyar
