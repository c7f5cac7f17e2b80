// SPDX-License-Identifier: MIT
// What the interface for C answers is what the one in C++ does.
#include <cstring>
#include <vector>

#include "c_api_film.hpp"
#include "handyar/attachment.hpp"

namespace handyar {
namespace {

TEST(CApi, OfTwoTrackersThatShareAViewOneLeavesTheHandToTheOther) {
  BothFilm both;
  const TrackerPointer second = tracker_with(nullptr, nullptr);
  handyar_share_view(both.tracker.get(), second.get());
  handyar_share_view(both.tracker.get(), nullptr);  // nothing happens
  auto result = sized<handyar_result>();
  for (int i = 0; i < 20; ++i) {
    both.play(1);
    ASSERT_EQ(handyar_process(second.get(), &both.frame, both.film.time_s, &result), HANDYAR_OK);
    EXPECT_EQ(result.state, HANDYAR_SEARCHING);
  }
  EXPECT_EQ(both.result.state, HANDYAR_TRACKING);
}

TEST(CApi, SaysWhatTheCppTrackerSays) {
  BothFilm both;  // for which neither camera nor hand was given
  both.play(30);
  const TrackResult& cpp = both.film.result;
  const handyar_result& c = both.result;
  ASSERT_EQ(both.status, HANDYAR_OK);
  ASSERT_EQ(c.state, HANDYAR_TRACKING);
  EXPECT_STREQ(handyar_state_name(c.state), "tracking");
  ASSERT_TRUE(c.has_pose && c.has_raw_pose && cpp.pose && cpp.raw_pose);
  EXPECT_EQ(c.layout,
            *cpp.layout == Layout::thumb_right ? HANDYAR_THUMB_RIGHT : HANDYAR_THUMB_LEFT);
  EXPECT_EQ(c.face, *cpp.face == Face::palm ? HANDYAR_PALM : HANDYAR_BACK);
  EXPECT_EQ(c.doubtful, cpp.doubtful);
  EXPECT_TRUE(c.scale_assumed);
  EXPECT_TRUE(c.camera_assumed);
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) {
      EXPECT_EQ(c.pose.T_camera_hand[row][column], cpp.pose->T_camera_hand(row, column));
      EXPECT_EQ(c.raw_pose.T_camera_hand[row][column], cpp.raw_pose->T_camera_hand(row, column));
    }
  for (int row = 0; row < 6; ++row)
    for (int column = 0; column < 6; ++column)
      EXPECT_EQ(c.pose.covariance[row][column], cpp.pose->covariance(row, column));
  EXPECT_EQ(c.pose.time_s, both.film.time_s);
  EXPECT_EQ(c.rms_px, cpp.raw_pose->rms_px);
  for (int f = 0; f < HANDYAR_FINGERS; ++f) {
    EXPECT_EQ(c.tips[f].px[0], cpp.tips[f].px.x());
    EXPECT_EQ(c.tips[f].px[1], cpp.tips[f].px.y());
    EXPECT_EQ(c.tips[f].seen, cpp.tips[f].seen);
    EXPECT_EQ(c.fingers[f].abduction_rad, cpp.fingers[f].abduction_rad);
    EXPECT_EQ(c.fingers[f].flexion_sigma_rad, cpp.fingers[f].flexion_sigma_rad);
  }
  for (int w = 0; w < HANDYAR_WEBS; ++w) EXPECT_EQ(c.webs[w].px[0], cpp.webs[w].px.x());

  handyar_pose ahead;
  const double later_s = both.film.time_s + 0.05;
  ASSERT_EQ(handyar_predict(both.tracker.get(), later_s, &ahead), HANDYAR_OK);
  EXPECT_EQ(ahead.time_s, later_s);
  EXPECT_EQ(ahead.T_camera_hand[0][3],
            both.film.tracker.predict(later_s)->T_camera_hand.translation().x());
}

TEST(CApi, TellsWhatTheFingersDo) {
  BothFilm both;
  std::vector<handyar_gesture_event> events;
  const auto watch = [&](const Posture& posture, int frames) {
    both.film.hand.state.posture = posture;
    for (int i = 0; i < frames; ++i) {
      both.play(1);
      const auto& cpp = both.film.result;
      EXPECT_EQ(both.result.gesture, static_cast<handyar_gesture>(cpp.gesture));
      EXPECT_EQ(both.result.gesture_event != HANDYAR_NO_EVENT, cpp.gesture_event.has_value());
      if (both.result.gesture_event != HANDYAR_NO_EVENT)
        events.push_back(both.result.gesture_event);
      ASSERT_EQ(both.result.has_held_pose, cpp.held_pose.has_value());
      if (cpp.held_pose) {
        EXPECT_EQ(both.result.held_pose.T_camera_hand[2][3],
                  cpp.held_pose->T_camera_hand.translation().z());
      }
    }
  };
  watch({}, 30);
  EXPECT_EQ(both.result.gesture, HANDYAR_OPEN);
  watch(test::kFist, 20);
  EXPECT_EQ(both.result.gesture, HANDYAR_FIST);
  EXPECT_TRUE(both.result.has_held_pose);
  double T[4][4];
  EXPECT_EQ(handyar_get_attachment(both.tracker.get(), HANDYAR_AT_PALM, T), HANDYAR_OK);
  watch({}, 20);
  EXPECT_EQ(events, (std::vector<handyar_gesture_event>{HANDYAR_GRAB, HANDYAR_RELEASE}));
}

TEST(CApi, ShowsTheHandOfTheLastFrame) {
  BothFilm both;
  auto mask = sized<handyar_mask>();
  EXPECT_EQ(handyar_get_mask(both.tracker.get(), &mask), HANDYAR_NO_HAND);
  EXPECT_EQ(handyar_get_outline(both.tracker.get(), nullptr, 0), 0u);
  both.play(30);
  ASSERT_EQ(handyar_get_mask(both.tracker.get(), &mask), HANDYAR_OK);
  const HandMask cpp = both.film.tracker.mask();
  ASSERT_EQ(mask.width, cpp.width);
  ASSERT_EQ(mask.height, cpp.height);
  for (int y = 0; y < mask.height; ++y)
    EXPECT_EQ(std::memcmp(mask.data + y * mask.stride_bytes, cpp.data + y * cpp.stride_bytes,
                          static_cast<std::size_t>(mask.width)),
              0);

  const std::size_t places = handyar_get_outline(both.tracker.get(), nullptr, 0);
  ASSERT_GT(places, 10u);
  std::vector<float> xy_px(2 * places, -1);
  EXPECT_EQ(handyar_get_outline(both.tracker.get(), xy_px.data(), places - 1), places);
  EXPECT_EQ(xy_px[2 * places - 1], -1) << "written beyond the capacity";
  EXPECT_NE(xy_px[2 * places - 3], -1);

  auto hand = sized<handyar_hand>();
  ASSERT_EQ(handyar_get_hand(both.tracker.get(), &hand), HANDYAR_OK);
  EXPECT_EQ(hand.tips_m[2][1], both.film.tracker.hand().tips_m(1, 2));
}

TEST(CApi, TellsWhereAnObjectStands) {
  BothFilm both;
  double T[4][4];
  EXPECT_EQ(handyar_get_attachment(both.tracker.get(), HANDYAR_AT_FACE, T), HANDYAR_NO_HAND);
  both.play(30);
  const handyar_attachment index_tip = HANDYAR_AT_TIP + 1;
  ASSERT_EQ(handyar_get_attachment(both.tracker.get(), index_tip, T), HANDYAR_OK);
  const Eigen::Isometry3d cpp =
      T_hand_attachment(Attachment::index_tip, both.film.tracker.hand(), both.film.result);
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) EXPECT_EQ(T[row][column], cpp(row, column));
  EXPECT_EQ(handyar_get_attachment(both.tracker.get(), HANDYAR_AT_TIP + 5, T),
            HANDYAR_BAD_ARGUMENT);
  EXPECT_EQ(handyar_get_attachment(both.tracker.get(), -1, T), HANDYAR_BAD_ARGUMENT);
  handyar_reset(both.tracker.get());
  EXPECT_EQ(handyar_get_attachment(both.tracker.get(), HANDYAR_AT_FACE, T), HANDYAR_NO_HAND);
}

TEST(CApi, WithoutSmoothingThePoseIsTheRawOne) {
  auto options = sized<handyar_options>();
  const TrackerPointer tracker = tracker_with(nullptr, &options);
  Film film;
  auto result = sized<handyar_result>();
  for (int i = 0; i < 30; ++i) {
    film.next();
    const Picture picture = film.picture();
    const handyar_frame frame = frame_of(picture);
    ASSERT_EQ(handyar_process(tracker.get(), &frame, film.time_s, &result), HANDYAR_OK);
  }
  ASSERT_TRUE(result.has_pose);
  for (int row = 0; row < 3; ++row)
    EXPECT_NEAR(result.pose.T_camera_hand[row][3], result.raw_pose.T_camera_hand[row][3], 1e-12);
}

TEST(CApi, AKnownSideTellsPalmFromBack) {
  for (const handyar_side side : {HANDYAR_LEFT_HAND, HANDYAR_RIGHT_HAND}) {
    auto options = sized<handyar_options>();
    handyar_default_options(&options);
    options.side = side;
    const TrackerPointer tracker = tracker_with(nullptr, &options);
    Film film;
    auto result = sized<handyar_result>();
    for (int i = 0; i < 20; ++i) {
      film.next();
      const Picture picture = film.picture();
      const handyar_frame frame = frame_of(picture);
      ASSERT_EQ(handyar_process(tracker.get(), &frame, film.time_s, &result), HANDYAR_OK);
      if (result.face != HANDYAR_UNKNOWN) {
        EXPECT_EQ(result.side, side);
      }
    }
    ASSERT_EQ(result.state, HANDYAR_TRACKING);
    const bool right_layout = result.layout == HANDYAR_THUMB_RIGHT;
    EXPECT_EQ(result.face,
              right_layout == (side == HANDYAR_RIGHT_HAND) ? HANDYAR_PALM : HANDYAR_BACK);
  }
}

TEST(CApi, ProjectsLikeTheCamera) {
  handyar_camera camera = camera_of(640, 480);
  camera.distortion[0] = 0.1;
  const double point_m[3] = {0.1, -0.05, 0.5};
  double px[2];
  ASSERT_EQ(handyar_project(&camera, point_m, px), HANDYAR_OK);
  Camera cpp = Camera::from_field_of_view(640, 480);
  cpp.distortion[0] = 0.1;
  const Eigen::Vector2d expected = cpp.project({0.1, -0.05, 0.5});
  EXPECT_NEAR(px[0], expected.x(), 1e-9);
  EXPECT_NEAR(px[1], expected.y(), 1e-9);
  const double behind_m[3] = {0, 0, -1};
  EXPECT_EQ(handyar_project(&camera, behind_m, px), HANDYAR_BAD_ARGUMENT);
}

}  // namespace
}  // namespace handyar
