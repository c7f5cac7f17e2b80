// SPDX-License-Identifier: MIT
// Writes the first COUNT frames of the shipped clip to standard output as raw RGB.
#include <cstdio>
#include <cstdlib>
#include <opencv2/imgproc.hpp>

#include "handyar/io/frame_source.hpp"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const auto source = handyar::io::open_input("sample");
  handyar::io::Frame frame;
  cv::Mat rgb;
  for (int left = std::atoi(argv[1]); left > 0 && source->read(frame); --left) {
    cv::cvtColor(frame.bgr, rgb, cv::COLOR_BGR2RGB);
    std::fwrite(rgb.data, 1, rgb.total() * rgb.elemSize(), stdout);
  }
}
