// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core.hpp>

#include "handyar/render/model.hpp"

namespace handyar::render {

/// Writes into every vertex how much of the sky it sees past the model itself and the ground below
/// it. The model must be standing (Model::standing).
void bake_openness(Model& model);

/// The soft shadow that a standing model throws on the ground z = 0, seen from above: 128x128,
/// 8-bit, two channels, over -1..1 in x (columns) and y (rows). First channel: where it touches the
/// ground; second: the whole model, softer.
cv::Mat bake_shadow(const Model& model);

}  // namespace handyar::render
