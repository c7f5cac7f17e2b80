// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>

namespace handyar::io {

/// Writes a picture (8-bit grey or BGR) whole or not at all, in the format of its name's extension;
/// throws Error.
void write_picture(const std::string& path, const cv::Mat& picture);

}  // namespace handyar::io
