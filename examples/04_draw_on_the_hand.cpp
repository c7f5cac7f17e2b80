// SPDX-License-Identifier: MIT
// Draws a wire cube that stands on the palm into the first frame of the shipped clip whose pose can
// be trusted:
//   04_draw_on_the_hand cube.png
#include <array>
#include <cstdio>
#include <exception>
#include <opencv2/imgproc.hpp>

#include "handyar/io/camera_file.hpp"
#include "handyar/io/frame_source.hpp"
#include "handyar/io/hand_file.hpp"
#include "handyar/io/picture_file.hpp"
#include "handyar/io/sample.hpp"
#include "handyar/tracker.hpp"

namespace {

void draw_cube(cv::Mat& picture, const handyar::Camera& camera,
               const Eigen::Isometry3d& T_camera_hand) {
  constexpr double kSide_m = 0.05;
  const Eigen::Vector3d corner_m(-kSide_m / 2, -0.03 - kSide_m / 2, 0.01);  // on the palm
  std::array<cv::Point2d, 8> px;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d p_hand = corner_m + kSide_m * Eigen::Vector3d(i & 1, i >> 1 & 1, i >> 2);
    const Eigen::Vector2d p = camera.project(T_camera_hand * p_hand);
    px[i] = {p.x(), p.y()};
  }
  for (int i = 0; i < 8; ++i)
    for (const int bit : {1, 2, 4})
      if ((i & bit) == 0)  // z points out of the hand: the far face is the one that touches it
        cv::line(picture, px[i], px[i | bit],
                 (i & 4) != 0 ? cv::Scalar(80, 220, 255) : cv::Scalar(60, 160, 60), 2, cv::LINE_AA);
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::fputs("usage: 04_draw_on_the_hand OUT.png\n", stderr);
    return 2;
  }
  const auto camera = handyar::io::read_camera(handyar::io::data_file("sample/camera.yml"));
  const auto hand = handyar::io::read_hand(handyar::io::data_file("sample/hand.json"));
  handyar::HandTracker tracker(camera, hand);

  const auto source = handyar::io::open_input("sample");
  handyar::io::Frame frame;
  while (source->read(frame)) {
    const handyar::TrackResult result = tracker.process(frame.view(), frame.time_s);
    if (!result.pose || result.doubtful) continue;
    draw_cube(frame.bgr, camera, result.pose->T_camera_hand);
    handyar::io::write_picture(argv[1], frame.bgr);
    std::printf("drawn on frame %d\n", static_cast<int>(frame.index));
    return 0;
  }
  return 1;
} catch (const std::exception& e) {
  std::fprintf(stderr, "%s\n", e.what());
  return 1;
}
