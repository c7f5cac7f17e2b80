// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace handyar::cli {

/// One run of `handyar calibrate`; an empty name: not wanted.
struct CalibrateRun {
  std::string input, camera_file, camera_out, hand_out, picture_out;
  std::string grid;
  double square_mm = 0, thickness_mm = 5;
  std::string method = "triangulation";
  bool self = false, show = false;
  bool assume_camera = false;              ///< with `self`, without a file: 60 degrees
  std::string live_camera_file;            ///< then taken where the input is a camera
  double span_mm = 0, hand_length_mm = 0;  ///< 0: not measured

  bool wants_hand() const { return !hand_out.empty() || !picture_out.empty(); }
};

/// The exit code. Throws io::Error and WrongUsage.
int calibrate(const CalibrateRun& run);

}  // namespace handyar::cli
