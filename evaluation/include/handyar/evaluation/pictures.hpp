// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "handyar/evaluation/analysis.hpp"

namespace handyar::evaluation {

/// A frame with what was found drawn on it.
struct Picture {
  int frame;
  std::string caption;
  bool worst;  ///< else a sample
  std::vector<unsigned char> jpeg;
};

/// A few frames spread over the sequence, and the worst ones: falsely or wrongly tracked, lost in
/// plain view, then those with the largest errors. Reads the video once more.
std::vector<Picture> take_pictures(const Analysis& analysis);

}  // namespace handyar::evaluation
