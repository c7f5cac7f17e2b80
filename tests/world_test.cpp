// SPDX-License-Identifier: MIT
#include "handyar/world/world_tracker.hpp"
#include "tabletop.hpp"
#include "temporary_folder.hpp"

namespace handyar::world {
namespace {

TEST(World, IsSetByTheHandAndStaysWhereItWas) {
  Tabletop table;
  WorldTracker tracker(table.camera);
  int set = -1, recognised = -1;
  double worst_rotation_rad = 0, worst_share = 0;
  for (int frame = 0; frame < kFrames; ++frame) {
    const Eigen::Isometry3d truth = orbit(frame);
    const bool with_hand = frame < kHandUntil;
    const cv::Mat bgr = table.draw(truth, with_hand);
    const auto result = tracker.process(
        bgr, frame * kFrame_s, table.hand(with_hand ? std::optional(truth) : std::nullopt));
    if (set < 0 && result.state == WorldState::tracked) set = frame;
    if (frame >= kAway && frame < kBack) {
      EXPECT_EQ(result.state, WorldState::lost) << frame;
      EXPECT_FALSE(result.T_camera_world) << frame;
      continue;
    }
    if (set < 0) continue;
    ASSERT_TRUE(frame >= kAway || result.state == WorldState::tracked) << frame;
    if (!result.T_camera_world) continue;
    if (frame >= kBack && recognised < 0) recognised = frame;
    const Errors off = errors(*result.T_camera_world, truth);
    worst_rotation_rad = std::max(worst_rotation_rad, off.rotation_rad);
    worst_share = std::max(worst_share, off.distance_m / truth.translation().norm());
  }
  EXPECT_GE(set, 15);  // half a second
  EXPECT_LT(set, 20);
  EXPECT_LT(worst_rotation_rad, 1 * kDegree);
  EXPECT_LT(worst_share, 0.01);
  EXPECT_GE(recognised, kBack);
  EXPECT_LE(recognised, kBack + 9);  // 0.3 s
}

TEST(World, IsNotTakenForOneKeyOffWhereThingsRepeat) {
  Tabletop table("table", keyboard_and_print);
  WorldTracker tracker(table.camera);
  int tracked = 0;
  for (int frame = 0; frame < 240; ++frame) {
    // Round the table, and away and back faster and faster.
    const double s = std::max(0, frame - 30) / 150.0;
    const int swing = std::max(0, frame - 60) % 60;
    const double away_rad =
        swing < 40 ? 0 : -0.6 * kDegree * std::pow(10 - std::abs(50 - swing), 2);
    const Eigen::Isometry3d truth =
        from(0.5 * std::sin(4 * s), 0.3 + 0.2 * std::sin(7 * s), 0.5, away_rad);
    const bool with_hand = frame < kHandUntil;
    const cv::Mat bgr = table.draw(truth, with_hand);
    const auto result = tracker.process(
        bgr, frame * kFrame_s, table.hand(with_hand ? std::optional(truth) : std::nullopt));
    if (!result.T_camera_world) continue;
    ++tracked;
    const Errors off = errors(*result.T_camera_world, truth);
    EXPECT_LT(off.rotation_rad, 3 * kDegree) << frame;
    EXPECT_LT(off.distance_m, 0.05 * truth.translation().norm()) << frame;
  }
  EXPECT_GT(tracked, 120);
}

TEST(World, AHandWithWrongTiltIsPutRightByTheMovingCamera) {
  Tabletop table;
  WorldTracker tracker(table.camera);
  // As the hand says, the frame is tilted by 3 degrees against the table.
  Eigen::Isometry3d T_table_hand = Eigen::Isometry3d::Identity();
  T_table_hand.linear() =
      Eigen::AngleAxisd(3 * kDegree, Eigen::Vector3d(1, 1, 0).normalized()).toRotationMatrix();
  for (int frame = 0; frame < kAway; ++frame) {
    const Eigen::Isometry3d truth = orbit(frame);
    const bool with_hand = frame < kHandUntil;
    const cv::Mat bgr = table.draw(truth, with_hand);
    tracker.process(bgr, frame * kFrame_s,
                    table.hand(with_hand ? std::optional(truth * T_table_hand) : std::nullopt));
  }
  ASSERT_TRUE(tracker.map());
  const Eigen::Vector3d up = T_table_hand.linear().transpose() * Eigen::Vector3d::UnitZ();
  const double off_rad = std::acos(std::min(1.0, up.dot(tracker.map()->ground.normal())));
  EXPECT_LT(off_rad, 0.5 * kDegree);
  EXPECT_GT(tracker.map()->keyframes.size(), 2u);
}

TEST(World, PicturesThatAreNotTheCamerasAreRefused) {
  Tabletop table;
  WorldTracker tracker(table.camera);
  const Eigen::Isometry3d truth = from(0, 0.5, 0.5);
  const cv::Mat bgr = table.draw(truth, true);
  for (int frame = 0; frame < 20; ++frame)
    tracker.process(bgr, frame * kFrame_s, table.hand(truth));
  cv::Mat half, grey;
  cv::resize(bgr, half, bgr.size() / 2);
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  for (const cv::Mat& other : {half, grey, cv::Mat()})
    EXPECT_THROW(tracker.process(other, 20 * kFrame_s, {}), cv::Exception) << other.size();
  EXPECT_EQ(tracker.process(bgr, 20 * kFrame_s, table.hand(truth)).state, WorldState::tracked);
}

TEST(World, IsRecognisedInAnotherRunAndByAnotherCameraAndNothingElseIs) {
  Tabletop table, other("another table");
  const test::TemporaryFolder folder;
  const std::string file = folder / "desk.map";
  write_map(file, made_map(table));
  const WorldMap map = read_map(file);
  table.camera = Camera::from_field_of_view(640, 480, 1.2);
  WorldTracker here(table.camera, map), elsewhere(other.camera, map);
  int recognised = 0;
  for (int frame = 0; frame < 20; ++frame) {
    const Eigen::Isometry3d truth = from(0.3 + 0.01 * frame, 0.55, 0.5);
    const auto result = here.process(table.draw(truth, false), frame * kFrame_s, table.hand({}));
    if (result.T_camera_world) {
      ++recognised;
      const Errors off = errors(*result.T_camera_world, truth);
      EXPECT_LT(off.rotation_rad, 1 * kDegree);
      EXPECT_LT(off.distance_m, 0.01 * truth.translation().norm());
    }
    const auto wrong =
        elsewhere.process(other.draw(truth, false), frame * kFrame_s, other.hand({}));
    EXPECT_EQ(wrong.state, WorldState::lost);
  }
  EXPECT_GE(recognised, 15);
}

TEST(World, IsRecognisedByACameraThatHasExposedAnew) {
  Tabletop table;
  WorldTracker tracker(table.camera, made_map(table));
  int recognised = 0;
  for (int frame = 0; frame < 20; ++frame) {
    const Eigen::Isometry3d truth = from(0.3 + 0.01 * frame, 0.55, 0.5);
    cv::Mat darker;
    table.draw(truth, false).convertTo(darker, -1, 0.5, 10);
    const auto result = tracker.process(darker, frame * kFrame_s, table.hand({}));
    if (!result.T_camera_world) continue;
    ++recognised;
    EXPECT_LT(errors(*result.T_camera_world, truth).rotation_rad, 1 * kDegree);
  }
  EXPECT_GE(recognised, 15);
}

TEST(World, MappingOnAThreadKeepsTheFrameToo) {
  Tabletop table;
  WorldTracker tracker(table.camera, Mapping::background);
  WorldResult result;
  for (int frame = 0; frame < kAway; ++frame) {
    const bool with_hand = frame < kHandUntil;
    const cv::Mat bgr = table.draw(orbit(frame), with_hand);
    result = tracker.process(bgr, frame * kFrame_s,
                             table.hand(with_hand ? std::optional(orbit(frame)) : std::nullopt));
  }
  ASSERT_TRUE(result.T_camera_world);
  EXPECT_LT(errors(*result.T_camera_world, orbit(kAway - 1)).rotation_rad, 1 * kDegree);
}

}  // namespace
}  // namespace handyar::world
