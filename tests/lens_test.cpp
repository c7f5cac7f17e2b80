// SPDX-License-Identifier: MIT
#include "handyar/opencv/lens.hpp"

#include <gtest/gtest.h>

namespace handyar {
namespace {

Camera barrel(double k1) {
  Camera camera = Camera::from_field_of_view(640, 480);
  camera.distortion[0] = k1;
  return camera;
}

TEST(Lens, WhatIsInTheFrameIsShownWhereTheCameraProjectsIt) {
  for (const double k1 : {0.0, 0.2, -0.2, -0.3, -0.4}) {
    const Camera camera = barrel(k1);
    for (int y_px = 0; y_px < 480; y_px += 40)
      for (int x_px = 80; x_px <= 560; x_px += 40) {
        const Eigen::Vector2d px(x_px, y_px);
        if ((px - Eigen::Vector2d(camera.cx_px, camera.cy_px)).norm() > 300) continue;
        const auto shown = shown_at(camera, 0.7 * camera.unproject(px).homogeneous());
        ASSERT_TRUE(shown) << k1 << " at " << px.transpose();
        EXPECT_LT((*shown - px).norm(), 1e-3) << k1 << " at " << px.transpose();
      }
  }
}

TEST(Lens, WhatLiesFarToTheSideDoesNotFoldBackIntoTheFrame) {
  const Camera camera = barrel(-0.3);
  const Eigen::Vector3d aside(1.7, 0.1, 1);
  EXPECT_LT(std::abs(camera.project(aside).x() - camera.cx_px), 320);
  EXPECT_FALSE(shown_at(camera, aside));
  for (double x = 1.1; x < 20; x *= 1.05) {
    EXPECT_FALSE(shown_at(camera, {x, 0, 1})) << x;
    EXPECT_FALSE(shown_at(camera, {x, -x, 1})) << x;
  }
  EXPECT_TRUE(shown_at(camera, {0.9, 0, 1}));
}

TEST(Lens, NothingIsShownOfWhatIsBehind) {
  EXPECT_FALSE(shown_at(barrel(0), {0.1, 0.1, -1}));
  EXPECT_FALSE(shown_at(barrel(-0.3), {0.1, 0.1, 0}));
  EXPECT_TRUE(shown_at(barrel(0), {20, 0, 1})) << "without distortion nothing folds";
}

}  // namespace
}  // namespace handyar
