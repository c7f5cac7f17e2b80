// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace handyar {

/// How a fingertip's place is measured (the paper's Table 2 compares them).
enum class FingertipMethod : std::uint8_t {
  curvature,  ///< the contour point of the sharpest turn
  ellipse     ///< the end of the major axis of an ellipse fitted around it
};

struct FingertipConfig {
  FingertipMethod method = FingertipMethod::ellipse;
};

}  // namespace handyar
