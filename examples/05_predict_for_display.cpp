// SPDX-License-Identifier: MIT
// What is seen on a display is late. Compares, on the shipped clip, the newest pose with the one
// predicted for the moment at which it is shown, 66 ms later.
#include <cstdio>
#include <deque>
#include <exception>

#include "handyar/io/camera_file.hpp"
#include "handyar/io/frame_source.hpp"
#include "handyar/io/hand_file.hpp"
#include "handyar/io/sample.hpp"
#include "handyar/tracker.hpp"

int main() try {
  constexpr std::size_t kLate_frames = 2;
  const auto camera = handyar::io::read_camera(handyar::io::data_file("sample/camera.yml"));
  const auto hand = handyar::io::read_hand(handyar::io::data_file("sample/hand.json"));
  handyar::HandTracker tracker(camera, hand);

  struct Shown {
    Eigen::Vector3d newest_m, predicted_m;
  };
  std::deque<Shown> waiting;  // for the frames by which they are judged
  double newest_sum_m = 0, predicted_sum_m = 0;
  int count = 0;

  const auto source = handyar::io::open_input("sample");
  const double latency_s = kLate_frames / source->info().fps;
  handyar::io::Frame frame;
  while (source->read(frame)) {
    const handyar::TrackResult result = tracker.process(frame.view(), frame.time_s);
    const auto predicted = tracker.predict(frame.time_s + latency_s);
    if (!result.pose || !predicted) {
      waiting.clear();
      continue;
    }
    const Eigen::Vector3d now_m = result.pose->T_camera_hand.translation();
    if (waiting.size() == kLate_frames) {
      newest_sum_m += (waiting.front().newest_m - now_m).norm();
      predicted_sum_m += (waiting.front().predicted_m - now_m).norm();
      ++count;
      waiting.pop_front();
    }
    waiting.push_back({now_m, predicted->T_camera_hand.translation()});
  }
  if (count == 0) return 1;
  std::printf("%.0f ms late: %.2f mm off with the newest pose, %.2f mm with the predicted one\n",
              1000 * latency_s, 1000 * newest_sum_m / count, 1000 * predicted_sum_m / count);
  std::puts(predicted_sum_m < newest_sum_m ? "prediction is closer" : "prediction is no closer");
} catch (const std::exception& e) {
  std::fprintf(stderr, "%s\n", e.what());
  return 1;
}
