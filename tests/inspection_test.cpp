// SPDX-License-Identifier: MIT
#include "handyar/render/inspection.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace handyar::render {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr double kFrame_s = 1.0 / 30;

/// Three objects; the hand is at `distance` from the middle one and far from the others.
class Story {
 public:
  void play(double seconds, double distance_px, bool tracked) {
    play(seconds, std::array{400.0, distance_px, 400.0}, tracked);
  }
  void play(double seconds, const std::array<double, 3>& distances_px, bool tracked) {
    const int frames = static_cast<int>(std::lround(seconds / kFrame_s));
    for (int i = 0; i < frames; ++i, now_s += kFrame_s) {
      if (const auto event = machine.update({now_s, distances_px, tracked})) {
        events.push_back(std::string(name(*event)) + " " + std::to_string(machine.object()));
        times_s.push_back(now_s);
      }
    }
  }

  Inspection machine;
  double now_s = 0;
  std::vector<std::string> events;
  std::vector<double> times_s;
};

using Events = std::vector<std::string>;

TEST(Inspection, ChoosesAttachesAndReleasesOnce) {
  Story s;
  s.play(1.0, kFar, false);
  s.play(1.0, 30, false);
  EXPECT_EQ(s.machine.phase(), InspectionPhase::selected);
  s.play(3.0, 150, true);
  EXPECT_EQ(s.machine.phase(), InspectionPhase::attached);
  EXPECT_EQ(s.machine.weight(), 1);
  s.play(2.0, kFar, false);
  EXPECT_EQ(s.machine.phase(), InspectionPhase::idle);
  EXPECT_EQ(s.events, (Events{"selected 1", "attached 1", "released 1"}));
  EXPECT_NEAR(s.times_s[0], 1.0 + 0.2, 0.04);
  EXPECT_NEAR(s.times_s[1], 2.0, 0.04);
  EXPECT_NEAR(s.times_s[2], 5.0 + 0.35, 0.05);
}

TEST(Inspection, APassingHandChoosesNothing) {
  Story s;
  for (int pass = 0; pass < 5; ++pass) {
    s.play(0.1, 20, true);
    s.play(0.3, 300, true);
  }
  EXPECT_TRUE(s.events.empty());
}

TEST(Inspection, ChoosesTheNearest) {
  Story s;
  s.play(1.0, {50, 40, 55}, false);
  EXPECT_EQ(s.events, (Events{"selected 1"}));
}

TEST(Inspection, ADistanceBetweenTheThresholdsNeitherChoosesNorLetsGo) {
  Story s;
  s.play(1.0, 80, false);
  EXPECT_TRUE(s.events.empty());
  s.play(0.5, 50, false);
  s.play(2.0, 80, false);
  EXPECT_EQ(s.machine.phase(), InspectionPhase::selected);
  s.play(0.3, kFar, false);  // a flicker of the hand
  s.play(0.5, 50, false);
  EXPECT_EQ(s.events, (Events{"selected 1"}));
  s.play(0.5, 120, false);
  EXPECT_EQ(s.machine.phase(), InspectionPhase::idle);
}

TEST(Inspection, ShowsTheChoiceBeforeItAttaches) {
  Story s;
  s.play(2.0, 30, true);
  ASSERT_EQ(s.events, (Events{"selected 1", "attached 1"}));
  EXPECT_GE(s.times_s[1] - s.times_s[0], 0.3 - 1e-9);
}

TEST(Inspection, AShortLossDoesNotRelease) {
  Story s;
  s.play(2.0, 30, true);
  s.play(0.3, 30, false);
  s.play(1.0, 30, true);
  EXPECT_EQ(s.machine.phase(), InspectionPhase::attached);
  EXPECT_EQ(s.machine.weight(), 1);
  EXPECT_EQ(s.events.size(), 2u);
}

TEST(Inspection, AfterAReleaseTheHandMustLeaveFirst) {
  Story s;
  s.play(2.0, 30, true);
  s.play(0.5, 30, false);
  s.play(3.0, 30, true);  // the hand never went away
  EXPECT_EQ(s.events, (Events{"selected 1", "attached 1", "released 1"}));
  s.play(0.2, 200, true);
  s.play(1.0, 30, true);
  EXPECT_EQ(s.events.size(), 5u);
}

TEST(Inspection, GoesAndReturnsInTheBlendTimeWithoutAJump) {
  Inspection machine;
  const std::array<double, 1> near_px = {10};
  double before = 0, largest = 0, began_s = -1, arrived_s = -1;
  for (double t = 0; t < 6; t += kFrame_s) {
    const auto event = machine.update({t, near_px, t < 3});
    if (event == InspectionEvent::attached) began_s = t;
    if (arrived_s < 0 && machine.weight() == 1) arrived_s = t;
    largest = std::max(largest, std::abs(machine.weight() - before));
    before = machine.weight();
  }
  EXPECT_NEAR(arrived_s - began_s, 0.6, 0.05);
  EXPECT_LT(largest, 1.5 * kFrame_s / 0.6 + 1e-3);  // the slope of the ease is 1.5 in the middle
  EXPECT_EQ(before, 0);
}

TEST(Inspection, ALossOnTheWayTurnsRound) {
  Story s;
  s.play(0.6, 30, true);
  ASSERT_EQ(s.events.size(), 2u);
  s.play(0.4, 30, false);
  const double weight = s.machine.weight();
  EXPECT_EQ(s.machine.phase(), InspectionPhase::returning);
  EXPECT_GT(weight, 0.3);
  s.play(0.1, 30, false);
  EXPECT_LT(s.machine.weight(), weight);
}

TEST(Blend, TurnsAsARotation) {
  Eigen::Isometry3d a = Eigen::Isometry3d::Identity(), b = a;
  b.linear() = Eigen::AngleAxisd(2.0, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  b.translation() = Eigen::Vector3d(0.1, -0.2, 0.4);
  for (double w : {0.0, 0.25, 0.5, 1.0}) {
    const Eigen::Isometry3d T = blend(a, b, w);
    EXPECT_NEAR(Eigen::AngleAxisd(T.linear()).angle(), 2.0 * w, 1e-9);
    EXPECT_TRUE(T.translation().isApprox(w * b.translation(), 1e-12));
    EXPECT_NEAR(T.linear().determinant(), 1, 1e-12);
  }
}

}  // namespace
}  // namespace handyar::render
