// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace handyar::io {

struct CameraInfo {
  std::string path;                           ///< "/dev/video0"
  std::string name;                           ///< "Integrated Camera"
  std::vector<std::pair<int, int>> sizes_px;  ///< width, height, smallest first, each once
  std::string fault;                          ///< why it cannot be opened; empty: it can
};

/// The cameras of this machine in the order of their numbers (V4L2; elsewhere empty).
std::vector<CameraInfo> list_cameras();

}  // namespace handyar::io
