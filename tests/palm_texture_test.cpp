// SPDX-License-Identifier: MIT
#include "align/palm_texture.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "drawn_hand.hpp"
#include "pose/so3.hpp"

namespace handyar {
namespace {

using test::deg;

/// A palm with creases, flat and without an outline, as it would fill the picture.
class PalmTextureTest : public testing::Test {
 protected:
  static constexpr double kHeight_m = 0.0035;  // of the figure's palm in the mean

  test::Picture picture_of(const Eigen::Isometry3d& T_camera_hand, double brightness = 1) const {
    test::Picture picture(camera.width_px, camera.height_px);
    const Eigen::Isometry3d T_hand_camera = T_camera_hand.inverse();
    const Eigen::Vector3d eye = T_hand_camera.translation();
    for (int y = 0; y < camera.height_px; ++y)
      for (int x = 0; x < camera.width_px; ++x) {
        const Eigen::Vector2d at = camera.unproject({x, y});
        const Eigen::Vector3d ray = T_hand_camera.linear() * Eigen::Vector3d(at.x(), at.y(), 1);
        const Eigen::Vector3d p = eye + (kHeight_m - eye.z()) / ray.z() * ray;
        const double skin = 130 + 18 * std::sin(p.x() / 0.004 + 2 * std::sin(p.y() / 0.015)) +
                            18 * std::sin(p.y() / 0.0045 + std::sin(p.x() / 0.011));
        for (int c = 0; c < 3; ++c)
          picture.at(x, y)[c] = static_cast<std::uint8_t>(std::lround(brightness * skin));
      }
    return picture;
  }

  static HandState state_at(const Eigen::Isometry3d& T_camera_hand) {
    HandState state;
    state.T_camera_hand = T_camera_hand;
    return state;
  }

  void learn(const Eigen::Isometry3d& T_camera_hand, Appearance appearance = {}) {
    Alignment a;
    a.valid = true;
    a.state = state_at(T_camera_hand);
    HandVector sigma = HandVector::Constant(1);
    sigma.head<3>().setConstant(deg(3));
    sigma.segment<3>(3).setConstant(0.004);
    a.information = sigma.cwiseAbs2().cwiseInverse().asDiagonal();
    texture.learn(picture_of(T_camera_hand).view(), camera, appearance, a, 0.1, 0.1);
  }

  /// Steps of Gauss-Newton by the texture alone, but for a vague prior.
  Eigen::Isometry3d follow(const test::Picture& picture, HandState state,
                           Appearance appearance = {}) const {
    for (int i = 0; i < 8; ++i) {
      HandMatrix H = 1e-2 * HandMatrix::Identity();
      HandVector g = HandVector::Zero();
      texture.pull(picture.view(), camera, appearance, state, H, g);
      state.correct(H.llt().solve(g));
    }
    return state.T_camera_hand;
  }

  static Eigen::Isometry3d tilted(const Eigen::Isometry3d& T, double across_rad, double up_rad) {
    Eigen::Isometry3d turned = T;
    turned.linear() =
        T.linear() * so3::exp(Eigen::Vector3d(across_rad, up_rad, 0)).toRotationMatrix();
    return turned;
  }

  const Camera camera = Camera::from_field_of_view(640, 480);
  const Eigen::Isometry3d straight = test::hand_at(0.35, 0, 0);
  PalmTexture texture;
};

TEST_F(PalmTextureTest, TellsHowThePalmHasTurned) {
  for (int i = 0; i < 40; ++i)
    learn(tilted(straight, deg(15) * std::sin(0.7 * i), deg(15) * std::cos(0.45 * i)));
  for (const double tilt : {-20, -12, 12, 20}) {
    const Eigen::Isometry3d now = tilted(straight, deg(tilt), deg(tilt / 2));
    HandState before;
    before.T_camera_hand = tilted(now, deg(3), deg(-3));
    EXPECT_LT(test::rotation_error_rad(follow(picture_of(now), before), now), deg(1.5)) << tilt;
    EXPECT_LT(test::rotation_error_rad(follow(picture_of(now, 0.7), before), now), deg(1.5))
        << tilt << ", darker";
  }
}

TEST_F(PalmTextureTest, SaysTheMoreTheMoreViewsThereWere) {
  double before = 0;
  for (const int frames : {4, 12}) {
    texture.forget();
    for (int i = 0; i < frames; ++i) learn(tilted(straight, deg(i), 0));
    HandMatrix H = HandMatrix::Zero();
    HandVector g = HandVector::Zero();
    texture.pull(picture_of(straight).view(), camera, {}, state_at(straight), H, g);
    EXPECT_GT(H(0, 0), 1.5 * before) << frames;
    // It lies where the outlines said, so it is never surer than they were together.
    EXPECT_LT(H(0, 0), 0.1 * frames / (deg(3) * deg(3)));
    before = H(0, 0);
  }
}

TEST_F(PalmTextureTest, SaysNothingOfWhatItHasNotSeen) {
  const auto silent = [&](Appearance appearance, const Eigen::Isometry3d& T_camera_hand) {
    HandMatrix H = HandMatrix::Zero();
    HandVector g = HandVector::Zero();
    texture.pull(picture_of(straight).view(), camera, appearance, state_at(T_camera_hand), H, g);
    EXPECT_TRUE(H.allFinite() && g.allFinite());
    return H.isZero(0) && g.isZero(0);
  };
  EXPECT_TRUE(silent({}, straight));
  for (int i = 0; i < 10; ++i) learn(straight);
  EXPECT_FALSE(silent({}, straight));
  EXPECT_TRUE(silent({Face::back, Layout::thumb_right}, straight));
  Eigen::Isometry3d gone = straight;
  gone.translation().x() += 5;
  EXPECT_TRUE(silent({}, gone)) << "out of the picture";
  gone.translation() = Eigen::Vector3d(0, 0, -0.3);
  EXPECT_TRUE(silent({}, gone)) << "behind the camera";
  gone.translation().setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_TRUE(silent({}, gone)) << "no place at all";
  texture.forget();
  EXPECT_TRUE(silent({}, straight));
}

}  // namespace
}  // namespace handyar
