// SPDX-License-Identifier: MIT
#include "handyar/planar_pose.hpp"

#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "synthetic_hand.hpp"

namespace handyar {
namespace {

using test::deg;
using test::hand_at;
using test::rendered_camera;
using test::rendered_hand;

TEST(PlanarPose, FindsTheExactPoseAmongItsTwo) {
  std::array<Eigen::Vector2d, 5> plane, image;
  const Camera camera = rendered_camera();
  for (double tilt : {0.0, 5.0, 20.0, 45.0, 70.0})
    for (double axis = 0; axis < 360; axis += 40) {
      const Eigen::Isometry3d truth = hand_at(0.45, deg(tilt), deg(axis), {0.05, 0.02});
      for (int i = 0; i < 5; ++i) {
        plane[i] = rendered_hand().tips_m.col(i).head<2>();
        const Eigen::Vector3d p(plane[i].x(), plane[i].y(), 0);
        image[i] = camera.unproject(camera.project(truth * p));
      }
      const auto poses = solve_planar(plane, image);
      ASSERT_TRUE(poses) << tilt << ' ' << axis;
      const Eigen::Isometry3d& T = (*poses)[0].T_camera_plane;
      EXPECT_LT(test::rotation_error_rad(T, truth), 1e-6) << tilt << ' ' << axis;
      EXPECT_LT(test::translation_error_m(T, truth), 1e-7) << tilt << ' ' << axis;
      EXPECT_LT((*poses)[0].rms, 1e-9);
      EXPECT_GE((*poses)[1].rms, (*poses)[0].rms);
    }
}

TEST(PlanarPose, TheOtherSolutionIsTheMirroredTilt) {
  std::array<Eigen::Vector2d, 5> plane, image;
  const Eigen::Isometry3d truth = hand_at(0.9, deg(20), deg(30));
  for (int i = 0; i < 5; ++i) {
    plane[i] = rendered_hand().tips_m.col(i).head<2>();
    image[i] = (truth * Eigen::Vector3d(plane[i].x(), plane[i].y(), 0)).hnormalized();
  }
  const auto poses = solve_planar(plane, image);
  ASSERT_TRUE(poses);
  const double apart =
      test::rotation_error_rad((*poses)[0].T_camera_plane, (*poses)[1].T_camera_plane);
  EXPECT_NEAR(apart, deg(40), deg(4));
}

TEST(PlanarPose, RefusesWhatDoesNotDetermineAPlane) {
  const std::array<Eigen::Vector2d, 4> square{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
  const std::array<Eigen::Vector2d, 4> line{{{0, 0}, {1, 1}, {2, 2}, {3, 3}}};
  const std::array<Eigen::Vector2d, 4> three_on_a_line{{{0, 0}, {1, 0}, {2, 0}, {0, 1}}};
  std::array<Eigen::Vector2d, 4> nan = square;
  nan[2].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(solve_planar(square, square));
  EXPECT_FALSE(solve_planar(std::span(square).first(3), std::span(square).first(3)));
  EXPECT_FALSE(solve_planar(square, std::span(square).first(3)));
  EXPECT_FALSE(solve_planar(line, square));
  EXPECT_FALSE(solve_planar(square, line));
  EXPECT_FALSE(solve_planar(three_on_a_line, three_on_a_line));
  EXPECT_FALSE(solve_planar(nan, square));
  EXPECT_FALSE(solve_planar(square, nan));
}

}  // namespace
}  // namespace handyar
