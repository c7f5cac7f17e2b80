// SPDX-License-Identifier: MIT
// Follows the hand in a video, a series of pictures or a live camera and says when its state
// changes:
//   03_track_video sample
//   03_track_video 0
#include <cstdio>
#include <exception>
#include <string>

#include "handyar/io/camera_file.hpp"
#include "handyar/io/frame_source.hpp"
#include "handyar/io/hand_file.hpp"
#include "handyar/tracker.hpp"

int main(int argc, char** argv) try {
  if (argc < 2) {
    std::fputs("usage: 03_track_video INPUT [camera.yml [hand.json]]\n", stderr);
    return 2;
  }
  const auto source = handyar::io::open_input(argv[1]);
  const auto& info = source->info();
  const handyar::Camera camera =
      argc > 2 ? handyar::io::read_camera(argv[2])
               : handyar::Camera::from_field_of_view(info.width_px, info.height_px);
  const handyar::HandModel hand =
      argc > 3 ? handyar::io::read_hand(argv[3]) : handyar::average_adult_hand();
  handyar::HandTracker tracker(camera, hand);

  handyar::State before = handyar::State::searching;
  handyar::io::Frame frame;
  while (source->read(frame)) {
    const handyar::TrackResult result = tracker.process(frame.view(), frame.time_s);
    if (result.status != handyar::FrameStatus::ok) {
      std::fprintf(stderr, "%s\n", handyar::describe(result.status));
      return 1;
    }
    if (result.state == before) continue;
    before = result.state;
    const std::string state(handyar::name(result.state));
    const std::string layout(result.layout ? handyar::name(*result.layout) : "");
    std::printf("%.3f s  %s  %s\n", frame.time_s, state.c_str(), layout.c_str());
    std::fflush(stdout);
  }
} catch (const std::exception& e) {
  std::fprintf(stderr, "%s\n", e.what());
  return 1;
}
