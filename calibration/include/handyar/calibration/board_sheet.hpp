// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>

#include "handyar/calibration/board.hpp"

namespace handyar {

/// The board to print, as a PDF of one page in true size: the smallest of A4, A3 (lying) that
/// holds it, else a page of its own size. A caption says what to check with a ruler.
std::string board_pdf(const Board& board);

/// The board to show on a screen, one channel, with a white margin of one square. Throws
/// CalibrationError when it would have more than 100 million pixels.
cv::Mat board_image(const Board& board, int square_px = 100);

}  // namespace handyar
