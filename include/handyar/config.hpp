// SPDX-License-Identifier: MIT
#pragma once

#include "handyar/fingertips.hpp"
#include "handyar/pose_filter.hpp"

namespace handyar {

/// All settings, a struct per stage; the defaults are what the command line uses.
struct Config {
  bool half_resolution = false;  ///< segment and find fingertips at half the input's size
  FingertipConfig fingertips;
  PoseConfig pose;
  PoseFilterConfig filter;

  /// Clock for StageTimes, in seconds; null: times stay zero. Nothing else depends on it.
  double (*now_s)() = nullptr;
};

}  // namespace handyar
