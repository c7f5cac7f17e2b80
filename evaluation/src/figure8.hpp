// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "handyar/evaluation/analysis.hpp"

namespace handyar::evaluation {

/// Draws the paper's Figure 8 of a sequence as a PNG by gnuplot: the errors of hand and markers at
/// the board over time, the tracker's states under them. False when gnuplot cannot be run.
/// Precondition: the board was seen.
bool draw_figure8(const Analysis& analysis, const std::string& file);

}  // namespace handyar::evaluation
