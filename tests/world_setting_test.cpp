// SPDX-License-Identifier: MIT
// When a hand sets the world, and what hinders it.
#include <algorithm>
#include <functional>
#include <map>

#include "tabletop.hpp"

namespace handyar::world {
namespace {

/// What hinders a hand in most of 1.5 s: the camera goes round the table by `turn_rad` a frame.
/// `T_table_hand` tells where the hand is in each frame.
Hindrance hindrance_of(Tabletop& table, double turn_rad,
                       const std::function<Eigen::Isometry3d(int)>& T_table_hand) {
  WorldTracker tracker(table.camera);
  std::map<Hindrance, int> frames;
  for (int frame = 0; frame < 45; ++frame) {
    const Eigen::Isometry3d T_camera_table = from(turn_rad * frame, 0.5, 0.5);
    const cv::Mat bgr = table.draw(T_camera_table, true);
    const auto result =
        tracker.process(bgr, frame * kFrame_s, table.hand(T_camera_table * T_table_hand(frame)));
    EXPECT_NE(result.state, WorldState::tracked) << frame;
    if (result.hindrance) ++frames[*result.hindrance];
  }
  EXPECT_FALSE(tracker.map());
  return std::max_element(frames.begin(), frames.end(),
                          [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

Eigen::Isometry3d displaced(double x_m, double z_m, double tilt_rad = 0) {
  return Eigen::Translation3d(x_m, 0, z_m) * Eigen::AngleAxisd(tilt_rad, Eigen::Vector3d::UnitX());
}

TEST(World, AHandThatMovesOverTheTableSetsNothing) {
  Tabletop table;
  const auto at_6_cm_s = [](int frame) { return displaced(0.002 * frame, 0); };
  EXPECT_EQ(hindrance_of(table, 0, at_6_cm_s), Hindrance::moving);
}

TEST(World, AHandAboveTheTableSetsNothing) {
  Tabletop table;
  for (const double height_m : {0.1, 0.15, 0.2}) {
    const auto held = [&](int) { return displaced(0, height_m); };
    EXPECT_EQ(hindrance_of(table, 0.01, held), Hindrance::off_ground) << height_m;
  }
}

TEST(World, AHandSeenFromTheSideSetsNothing) {
  Tabletop table;
  const auto upright = [](int) { return displaced(0, 0, -1.9); };
  EXPECT_EQ(hindrance_of(table, 0, upright), Hindrance::tilted);
}

TEST(World, AHandOnABareTableSetsNothing) {
  Tabletop table;
  WorldTracker tracker(table.camera);
  const Eigen::Isometry3d truth = from(0, 0.5, 0.5);
  const cv::Mat bare(table.draw(truth, true).size(), CV_8UC3, cv::Scalar(90, 80, 70));
  for (int frame = 0; frame < 20; ++frame)
    EXPECT_EQ(tracker.process(bare, frame * kFrame_s, table.hand(truth)).hindrance,
              Hindrance::bare);
  EXPECT_FALSE(tracker.map());
}

TEST(World, AHandThatHasJustComeIsNotMissed) {
  Tabletop table;
  WorldTracker tracker(table.camera);
  const Eigen::Isometry3d truth = from(0, 0.5, 0.5);
  const WorldResult first = tracker.process(table.draw(truth, true), 0, table.hand(truth));
  EXPECT_EQ(first.state, WorldState::setting);
  EXPECT_FALSE(first.hindrance);
}

TEST(World, TellsWhetherItWaitsForAHandOrForASurePose) {
  Tabletop table;
  WorldTracker tracker(table.camera);
  const Eigen::Isometry3d truth = from(0, 0.5, 0.5);
  EXPECT_EQ(tracker.process(table.draw(truth, false), 0, table.hand({})).hindrance,
            Hindrance::no_hand);
  const cv::Mat bgr = table.draw(truth, true);
  HandInWorld unsure = table.hand(truth);
  unsure.T_camera_hand.reset();
  EXPECT_EQ(tracker.process(bgr, kFrame_s, unsure).hindrance, Hindrance::unsure);
  // Then it lies still.
  for (int frame = 2; frame < 20; ++frame) {
    const auto result = tracker.process(bgr, frame * kFrame_s, table.hand(truth));
    EXPECT_TRUE(frame < 11 || !result.hindrance) << frame;
  }
  EXPECT_TRUE(tracker.map());
}

}  // namespace
}  // namespace handyar::world
