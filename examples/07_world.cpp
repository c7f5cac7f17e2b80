// SPDX-License-Identifier: MIT
// The hand that lies on a table sets the frame of the table; says where the camera is in it, once a
// second, hand or no hand:
//   07_world data/desk/video.mp4
//   07_world 0
#include <cstdio>
#include <exception>
#include <string>

#include "handyar/io/frame_source.hpp"
#include "handyar/tracker.hpp"
#include "handyar/world/world_tracker.hpp"

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::fputs("usage: 07_world INPUT\n", stderr);
    return 2;
  }
  const auto source = handyar::io::open_input(argv[1]);
  const auto& info = source->info();
  const auto camera = handyar::Camera::from_field_of_view(info.width_px, info.height_px);
  handyar::HandTracker hands(camera, handyar::average_adult_hand());
  handyar::world::WorldTracker worlds(camera);

  double next_s = 0;
  handyar::io::Frame frame;
  while (source->read(frame)) {
    const handyar::TrackResult hand = hands.process(frame.view(), frame.time_s);
    const auto world =
        worlds.process(frame.bgr, frame.time_s, handyar::world::HandInWorld::of(hands, hand));
    if (frame.time_s < next_s) continue;
    next_s += 1;
    std::printf("%.1f s  %s", frame.time_s, std::string(name(world.state)).c_str());
    if (world.T_camera_world) {
      const Eigen::Vector3d camera_m = world.T_camera_world->inverse().translation();
      std::printf("  camera at %.2f %.2f %.2f m%s", camera_m.x(), camera_m.y(), camera_m.z(),
                  hand.pose ? ", hand in view" : "");
    }
    std::printf("\n");
    std::fflush(stdout);
  }
} catch (const std::exception& e) {
  std::fprintf(stderr, "%s\n", e.what());
  return 1;
}
