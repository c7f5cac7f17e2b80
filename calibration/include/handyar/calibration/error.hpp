// SPDX-License-Identifier: MIT
#pragma once

#include <stdexcept>

namespace handyar {

/// A calibration that cannot be trusted. what() is one line for the person who made the recording:
/// what is wrong with it and what to do about it.
struct CalibrationError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace handyar
