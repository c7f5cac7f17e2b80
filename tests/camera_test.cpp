// SPDX-License-Identifier: MIT
#include "handyar/camera.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace handyar {
namespace {

Camera distorted_camera() {
  Camera c;
  c.fx_px = 610;
  c.fy_px = 605;
  c.cx_px = 322;
  c.cy_px = 238;
  c.distortion = {-0.21, 0.09, 0.0012, -0.0007, -0.01};
  return c;
}

TEST(Camera, UnprojectUndoesProject) {
  const Camera c = distorted_camera();
  for (double x = -0.4; x <= 0.4; x += 0.1)
    for (double y = -0.3; y <= 0.3; y += 0.1) {
      const Eigen::Vector2d n = c.unproject(c.project({x * 0.7, y * 0.7, 0.7}));
      EXPECT_NEAR(n.x(), x, 1e-10);
      EXPECT_NEAR(n.y(), y, 1e-10);
    }
}

TEST(Camera, JacobianAgreesWithCentralDifferences) {
  const Camera c = distorted_camera();
  const Eigen::Vector3d p(0.11, -0.07, 0.45);
  Eigen::Matrix<double, 2, 3> J;
  (void)c.project(p, &J);
  const double h = 1e-6;
  for (int i = 0; i < 3; ++i) {
    Eigen::Vector3d d = Eigen::Vector3d::Zero();
    d[i] = h;
    const Eigen::Vector2d numeric = (c.project(p + d) - c.project(p - d)) / (2 * h);
    EXPECT_LT((J.col(i) - numeric).norm(), 1e-4 * std::max(1.0, numeric.norm()));
  }
}

TEST(Camera, FieldOfViewSpansTheLongerSide) {
  const Camera landscape = Camera::from_field_of_view(640, 480),
               portrait = Camera::from_field_of_view(480, 640);
  EXPECT_NEAR(landscape.fx_px, 320 / std::tan(M_PI / 6), 1e-9);
  EXPECT_NEAR(portrait.fy_px, landscape.fx_px, 1e-9);
  EXPECT_TRUE(landscape.assumed);
}

TEST(Camera, AnAssumedFieldOfViewHoldsAtEveryAspect) {
  const Camera wide = Camera::from_field_of_view(640, 480).scaled_to(1920, 1080);
  const Camera expected = Camera::from_field_of_view(1920, 1080);
  EXPECT_NEAR(wide.fx_px, expected.fx_px, 1e-9);
  EXPECT_NEAR(wide.fy_px, expected.fy_px, 1e-9);
  EXPECT_NEAR(wide.cy_px, expected.cy_px, 1e-9);
}

TEST(Camera, ScalingKeepsPixelEdgesInPlace) {
  const Camera c = distorted_camera(), half = c.scaled_to(320, 240);
  const Eigen::Vector3d p(0.1, 0.05, 0.6);
  const Eigen::Vector2d full_px = c.project(p), half_px = half.project(p);
  EXPECT_NEAR((full_px.x() + 0.5) / 2 - 0.5, half_px.x(), 1e-9);
  EXPECT_NEAR((full_px.y() + 0.5) / 2 - 0.5, half_px.y(), 1e-9);
}

}  // namespace
}  // namespace handyar
