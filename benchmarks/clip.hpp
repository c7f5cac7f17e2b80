// SPDX-License-Identifier: MIT
#pragma once

#include <benchmark/benchmark.h>

#include <opencv2/core/mat.hpp>
#include <vector>

#include "handyar/camera.hpp"
#include "handyar/hand_model.hpp"
#include "handyar/image_view.hpp"

namespace handyar::benchmarks {

/// A shipped clip in which hand and marker are both in view, decoded beforehand: 640x480, BGR.
struct Clip {
  std::vector<cv::Mat> frames;
  Camera camera;
  HandModel hand;
};
const Clip& clip();

/// The clip's last frames enlarged to this height and widened at both sides by their outermost
/// columns. Only the size asked for last is kept.
const Clip& clip_at(int width, int height);

inline ImageView view(const cv::Mat& bgr) {
  return {bgr.data, bgr.cols, bgr.rows, static_cast<std::ptrdiff_t>(bgr.step[0])};
}

/// Processor time of this thread: what others do on the machine does not count.
double now_s();

/// The value that a share of all values lies below; the values are left in another order.
double quantile(std::vector<double>& values, double share);

void register_tracker_benchmarks();
void register_stage_benchmarks();

}  // namespace handyar::benchmarks
