// SPDX-License-Identifier: MIT
#include <cstdio>
#include <string>
#include <vector>

#include "handyar/tracker.hpp"

// Every header of the core that the tracker does not bring along.
#include "handyar/attachment.hpp"
#include "handyar/paper/any_tracker.hpp"
#include "handyar/paper/tip_pose.hpp"
#include "handyar/planar_pose.hpp"
#include "handyar/pose_filter.hpp"
#include "handyar/stages/align.hpp"
#include "handyar/stages/evidence.hpp"
#include "handyar/stages/hand_figure.hpp"
#include "handyar/stages/hand_finder.hpp"

int main() {
  handyar::HandTracker tracker(handyar::Camera::from_field_of_view(320, 240),
                               handyar::average_adult_hand());
  const std::vector<std::uint8_t> black(320 * 240 * 3);
  const auto result = tracker.process({black.data(), 320, 240, 320 * 3}, 0.0);
  std::printf("%s\n", std::string(handyar::name(result.state)).c_str());
  return result.status == handyar::FrameStatus::ok && !result.pose ? 0 : 1;
}
