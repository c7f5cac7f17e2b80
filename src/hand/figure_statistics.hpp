// SPDX-License-Identifier: MIT
#pragma once

#include "handyar/stages/hand_figure.hpp"

namespace handyar {

namespace statistics {
#include "hand/figure_statistics.inc"
}
using statistics::kFigureMean_m, statistics::kFigureModes_m, statistics::kFigureSigma_m,
    statistics::kFigureNumbers;
static_assert(kFigureModes <= statistics::kFigureModes);

/// Where in a figure's numbers those of the fingertips begin.
inline constexpr int kTipOffset = 4 * kSphereCount;

}  // namespace handyar
