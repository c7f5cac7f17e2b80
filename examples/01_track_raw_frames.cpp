// SPDX-License-Identifier: MIT
// Tracks a hand in raw 640x480 RGB frames from standard input. The core library alone is needed:
//   ffmpeg -v error -i hand.mp4 -vf scale=640:480 -pix_fmt rgb24 -f rawvideo - |
//     01_track_raw_frames
#include <cstdio>
#include <vector>

#include "handyar/tracker.hpp"

int main() {
  const auto camera = handyar::Camera::from_field_of_view(640, 480);  // or a calibrated one
  handyar::HandTracker tracker(camera, handyar::average_adult_hand());

  std::vector<std::uint8_t> rgb(640 * 480 * 3);
  const handyar::ImageView frame{rgb.data(), 640, 480, 640 * 3, handyar::PixelFormat::rgb};

  for (double time_s = 0; std::fread(rgb.data(), rgb.size(), 1, stdin) == 1; time_s += 1 / 30.0) {
    const handyar::TrackResult result = tracker.process(frame, time_s);
    if (!result.pose) continue;
    const Eigen::Vector3d hand_m = result.pose->T_camera_hand.translation();
    std::printf("%.2f s  hand at %.3f %.3f %.3f m\n", time_s, hand_m.x(), hand_m.y(), hand_m.z());
  }
}
