// SPDX-License-Identifier: MIT
#include "handyar/render/hand_overlay.hpp"

#include "handyar/attachment.hpp"
#include "rendered_scene.hpp"

namespace handyar::render {
namespace {

struct OverlayTest : RendererTest {
  HandOverlay overlay{cube(), 0.05};
  const HandModel hand = average_adult_hand();
  const Isometry3d on_palm = T_hand_attachment(Attachment::face, hand, {});

  /// Colour over the palm after a frame with or without the hand.
  cv::Vec3b step(double time_s, const std::optional<Isometry3d>& T_camera_hand, Layout layout) {
    cv::Mat bgr = frame();
    overlay.draw(bgr, camera, time_s, T_camera_hand, hand.for_layout(layout), mask(), on_palm);
    return at(bgr, hand_at(0.45) * Vector3d(0, hand.palm_centre_m().y(), 0.05));
  }
};

TEST_F(OverlayTest, ComesAndGoesWithoutAJump) {
  hand_covers({220, 140, 200, 300});
  cv::Vec3b before = step(0, std::nullopt, Layout::thumb_right);
  EXPECT_EQ(before, kSkin);
  int changes = 0;
  for (int i = 1; i <= 60; ++i) {
    const bool seen = i <= 30;
    const cv::Vec3b now =
        step(i / 30.0, seen ? std::optional(hand_at(0.45)) : std::nullopt, Layout::thumb_right);
    EXPECT_LT(cv::norm(now, before), 70) << "frame " << i;
    changes += cv::norm(now, before) > 5;
    before = now;
    if (i == 25) {
      EXPECT_GT(cv::norm(now, kSkin), 40);
    }
  }
  EXPECT_EQ(before, kSkin);
  EXPECT_GE(changes, 6);
}

TEST_F(OverlayTest, DoesNotHangInTheAirThatTheHandHasLeft) {
  hand_covers({220, 140, 200, 300});
  for (int i = 0; i < 20; ++i) step(i / 30.0, hand_at(0.45), Layout::thumb_right);
  for (int i = 20; i < 24; ++i) step(i / 30.0, std::nullopt, Layout::thumb_right);
  EXPECT_EQ(step(24 / 30.0, std::nullopt, Layout::thumb_right), kSkin);
}

TEST_F(OverlayTest, AfterAFlipItLeavesOneFaceBeforeItComesOnTheOther) {
  hand_covers({220, 140, 200, 300});
  for (int i = 0; i < 20; ++i) step(i / 30.0, hand_at(0.45), Layout::thumb_right);
  double least = 1e9;
  cv::Vec3b last;
  for (int i = 20; i < 60; ++i) {
    last = step(i / 30.0, hand_at(0.45), Layout::thumb_left);
    least = std::min(least, cv::norm(last, kSkin));
  }
  EXPECT_LT(least, 4);
  EXPECT_GT(cv::norm(last, kSkin), 40);
}

TEST_F(OverlayTest, AfterAFlipItLeavesFromWhereItStood) {
  hand_covers({0, 0, 640, 480});
  HandOverlay dot(cube(), 0.01, Attachment::thumb_tip);
  const auto column_px = [&](double time_s, Layout layout) {
    const HandModel shown = hand.for_layout(layout);
    cv::Mat bgr = frame(), grey;
    dot.draw(bgr, camera, time_s, hand_at(0.45), shown, mask(),
             T_hand_attachment(Attachment::thumb_tip, shown, {}));
    cv::absdiff(bgr, frame(), bgr);
    cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
    const cv::Moments m = cv::moments(grey);
    return m.m10 / m.m00;
  };
  double before_px = 0;
  for (int i = 0; i < 20; ++i) before_px = column_px(i / 30.0, Layout::thumb_right);
  for (int i = 20; i < 22; ++i)
    EXPECT_NEAR(column_px(i / 30.0, Layout::thumb_left), before_px, 1) << "frame " << i;
}

TEST_F(OverlayTest, DoesNotStandBesideTheHand) {
  hand_covers({20, 140, 200, 300});  // the palm is at column 320
  for (int i = 0; i < 20; ++i)
    EXPECT_EQ(step(i / 30.0, hand_at(0.45), Layout::thumb_right), kRoom) << "frame " << i;
}

TEST_F(OverlayTest, StandsOnThePalmPoint) {
  HandOverlay dot(cube(), 0.004);
  for (double tilt : {-0.9, 0.0, 0.9}) {
    const Isometry3d T = hand_at(0.45, tilt);
    hand_covers({0, 0, 640, 480});
    cv::Mat bgr, gray;
    for (int i = 0; i < 12; ++i) {
      bgr = frame();
      dot.draw(bgr, camera, 10 * tilt + 20 + i / 30.0, T, hand, mask(), on_palm);
    }
    cv::absdiff(bgr, frame(), bgr);
    cv::cvtColor(bgr, gray, cv::COLOR_BGR2GRAY);
    const cv::Moments m = cv::moments(gray);
    const Vector2d px = camera.project(T * hand.palm_centre_m());
    EXPECT_LT((Vector2d(m.m10, m.m01) / m.m00 - px).norm(), 3) << "tilt " << tilt;
  }
}

}  // namespace
}  // namespace handyar::render
