// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "gpu_model.hpp"
#include "handyar/render/renderer.hpp"

namespace handyar::render {

/// Part of the frame that the instances and their shadows can touch.
cv::Rect region_of(const Camera& camera, std::span<const Instance> instances,
                   const std::vector<GpuModel>& models);

}  // namespace handyar::render
