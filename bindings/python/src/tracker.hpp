// SPDX-License-Identifier: MIT
#pragma once

#include "handyar/tracker.hpp"
#include "shared.hpp"

namespace handyar::python {

struct TrackerState {
  Camera camera;
  HandTracker tracker;
  int width_px = 0, height_px = 0;  ///< of the last frame; zero before the first
};

using Tracker = Shared<TrackerState>;

}  // namespace handyar::python
