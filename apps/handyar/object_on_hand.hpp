// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "tracking_run.hpp"

namespace handyar::cli {

/// Stands a model (`teapot`, `bunny`, or a file) on the hand, its longest side `size_m`. Throws
/// io::Error when it cannot be read or drawn.
Overlay object_on_hand(const std::string& model, double size_m);

}  // namespace handyar::cli
