// SPDX-License-Identifier: MIT
#include "handyar/world/placement.hpp"

#include <gtest/gtest.h>

namespace handyar::world {
namespace {

constexpr double kFrame_s = 1 / 30.0;
const Eigen::Hyperplane<double, 3> kGround(Eigen::Vector3d::UnitZ(), 0.0);

Eigen::Isometry3d at(double x, double z) {
  return Eigen::Isometry3d(Eigen::Translation3d(x, 0, z));
}

/// A hand that is somewhere for a while; what happened last meanwhile.
struct Hand {
  Placement& placement;
  double time_s = 0;
  std::optional<PlacementEvent> stays(const std::optional<Eigen::Isometry3d>& T, double for_s) {
    std::optional<PlacementEvent> last;
    for (const double until_s = time_s + for_s; time_s < until_s; time_s += kFrame_s)
      if (const auto event = placement.update(time_s, kGround, T)) last = event;
    return last;
  }
  std::optional<PlacementEvent> goes(double from_x, double to_x, double z, double for_s) {
    std::optional<PlacementEvent> last;
    const double start_s = time_s;
    for (; time_s < start_s + for_s; time_s += kFrame_s) {
      const double x = from_x + (to_x - from_x) * (time_s - start_s) / for_s;
      if (const auto event = placement.update(time_s, kGround, at(x, z))) last = event;
    }
    return last;
  }
};

TEST(Placement, IsPickedUpCarriedAndPutDownWhereTheHandLies) {
  Placement placement(at(0, 0.02));
  Hand hand{placement};
  EXPECT_EQ(hand.stays(at(0, 0.02), 2), std::nullopt);  // it set the frame: it must leave first
  EXPECT_NEAR(placement.T_world_object().translation().z(), 0.02, 1e-9);  // on the hand
  EXPECT_EQ(hand.stays(at(0.3, 0.02), 1), std::nullopt);
  EXPECT_NEAR(placement.T_world_object().translation().z(), 0, 1e-9);  // on the table
  EXPECT_EQ(hand.stays(at(0, 0.02), 0.6), PlacementEvent::picked_up);
  EXPECT_EQ(hand.goes(0, 0.25, 0.1, 1), std::nullopt);
  EXPECT_TRUE(placement.carried());
  EXPECT_EQ(hand.stays(at(0.25, 0.03), 1), PlacementEvent::put_down);
  EXPECT_EQ(hand.stays(std::nullopt, 1), std::nullopt);
  EXPECT_NEAR((placement.T_world_object().translation() - Eigen::Vector3d(0.25, 0, 0)).norm(), 0,
              1e-3);
}

TEST(Placement, StaysWhereTheHandIsGone) {
  Placement placement(at(0, 0));
  Hand hand{placement};
  hand.stays(std::nullopt, 0.5);
  hand.stays(at(0.3, 0.1), 0.2);
  ASSERT_EQ(hand.stays(at(0, 0.05), 0.6), PlacementEvent::picked_up);
  hand.goes(0, 0.2, 0.1, 1);
  EXPECT_EQ(hand.stays(std::nullopt, 0.3), std::nullopt);  // a short loss changes nothing
  EXPECT_EQ(hand.stays(std::nullopt, 2), PlacementEvent::put_down);
  EXPECT_NEAR(placement.T_world_object().translation().x(), 0.2, 0.01);
  EXPECT_NEAR(placement.T_world_object().translation().z(), 0, 1e-9);
}

TEST(Placement, AHandThatPassesTakesNothing) {
  Placement placement(at(0, 0));
  Hand hand{placement};
  EXPECT_EQ(hand.goes(-0.4, 0.4, 0.05, 1.2), std::nullopt);
  EXPECT_FALSE(placement.carried());
}

}  // namespace
}  // namespace handyar::world
