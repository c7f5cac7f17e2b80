// SPDX-License-Identifier: MIT
// What the interface for C refuses, and how programs made for another version pass structs to it.
#include <cstddef>
#include <cstring>
#include <limits>

#include "c_api_film.hpp"

namespace handyar {
namespace {

TEST(CApi, AnOlderProgramsSmallerStructIsFilledToItsEnd) {
  BothFilm both;
  both.play(30);
  const TrackResult& cpp = both.film.next();
  const Picture picture = both.film.picture();
  const handyar_frame frame = frame_of(picture);
  handyar_result older;
  older.size = offsetof(handyar_result, gesture);
  older.gesture = 7;
  ASSERT_EQ(handyar_process(both.tracker.get(), &frame, both.film.time_s, &older), HANDYAR_OK);
  EXPECT_EQ(older.size, offsetof(handyar_result, gesture));
  EXPECT_EQ(older.fingers[4].flexion_sigma_rad, cpp.fingers[4].flexion_sigma_rad);
  EXPECT_EQ(older.gesture, 7) << "written beyond its end";
}

TEST(CApi, ARefusedFrameHasAReasonAndNoPose) {
  BothFilm both;
  both.play(30);
  ASSERT_TRUE(both.result.has_pose);
  const auto refused = [&](handyar_status why, auto change) {
    handyar_frame frame = both.frame;
    double time_s = both.film.time_s + 1;
    change(frame, time_s);
    both.result.has_pose = 1;
    EXPECT_EQ(handyar_process(both.tracker.get(), &frame, time_s, &both.result), why);
    EXPECT_FALSE(both.result.has_pose);
    EXPECT_STRNE(handyar_describe(why), "unknown");
  };
  refused(HANDYAR_NO_DATA, [](handyar_frame& f, double&) { f.data = nullptr; });
  refused(HANDYAR_GRAY_UNSUPPORTED, [](handyar_frame& f, double&) { f.format = HANDYAR_GRAY; });
  refused(HANDYAR_BAD_ARGUMENT, [](handyar_frame& f, double&) { f.format = 99; });
  refused(HANDYAR_SIZE_UNSUPPORTED, [](handyar_frame& f, double&) { f.width_px = 100000; });
  refused(HANDYAR_STRIDE_TOO_SMALL, [](handyar_frame& f, double&) { f.stride_bytes = 3; });
  refused(HANDYAR_TIME_NOT_INCREASING, [](handyar_frame&, double& t) { t = 0; });
  both.play(1);
  EXPECT_TRUE(both.result.has_pose) << "refused frames change nothing in the tracker";
}

TEST(CApi, AStructWhoseSizeIsNotSetIsRefused) {
  handyar_camera camera{};
  EXPECT_EQ(handyar_camera_from_field_of_view(640, 480, 1, &camera), HANDYAR_BAD_SIZE);
  handyar_hand hand{};
  EXPECT_EQ(handyar_average_hand(&hand), HANDYAR_BAD_SIZE);
  handyar_options options{};
  EXPECT_EQ(handyar_default_options(&options), HANDYAR_BAD_SIZE);
  handyar_tracker* tracker = nullptr;
  EXPECT_EQ(handyar_create(&camera, nullptr, nullptr, &tracker), HANDYAR_BAD_SIZE);
  EXPECT_EQ(tracker, nullptr);
  const TrackerPointer good = tracker_with(nullptr, nullptr);
  handyar_result result{};
  const Picture picture(640, 480);
  const handyar_frame frame = frame_of(picture);
  EXPECT_EQ(handyar_process(good.get(), &frame, 1, &result), HANDYAR_BAD_SIZE);
}

TEST(CApi, ANewerProgramsLargerStructIsFilledWithZeros) {
  struct {
    handyar_options options;
    double later_field;
  } newer{};
  newer.options.size = sizeof newer;
  newer.later_field = 7;
  ASSERT_EQ(handyar_default_options(&newer.options), HANDYAR_OK);
  EXPECT_EQ(newer.options.size, sizeof newer);
  EXPECT_EQ(newer.options.smoothing, 1);
  EXPECT_EQ(newer.later_field, 0);
}

TEST(CApi, ValuesThatMeanNothingAreRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const handyar_camera camera = camera_of(640, 480);
  const auto refused = [](const handyar_camera& c, const handyar_hand* h,
                          const handyar_options* o) {
    handyar_tracker* tracker = nullptr;
    EXPECT_EQ(handyar_create(&c, h, o, &tracker), HANDYAR_BAD_ARGUMENT);
    EXPECT_EQ(tracker, nullptr);
  };
  for (double handyar_camera::*value : {&handyar_camera::fx_px, &handyar_camera::cy_px}) {
    handyar_camera bad = camera;
    bad.*value = nan;
    refused(bad, nullptr, nullptr);
  }
  handyar_camera flat = camera;
  flat.width_px = 0;
  refused(flat, nullptr, nullptr);

  handyar_hand hand = average_hand();
  hand.layout = HANDYAR_UNKNOWN;
  refused(camera, &hand, nullptr);
  hand = average_hand();
  hand.tips_m[4][1] = nan;
  refused(camera, &hand, nullptr);
  hand = average_hand();
  std::memset(hand.tips_m, 0, sizeof hand.tips_m);
  refused(camera, &hand, nullptr);

  auto options = sized<handyar_options>();
  options.smoothing = -1;
  refused(camera, nullptr, &options);
  options.smoothing = 1;
  options.side = 3;
  refused(camera, nullptr, &options);

  EXPECT_EQ(handyar_create(nullptr, nullptr, nullptr, nullptr), HANDYAR_BAD_ARGUMENT);
  EXPECT_EQ(handyar_process(nullptr, nullptr, 0, nullptr), HANDYAR_BAD_ARGUMENT);
  handyar_destroy(nullptr);
}

TEST(CApi, WhatIsNoNumberIsNotProjected) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const handyar_camera camera = camera_of(640, 480);
  const auto project = [](const handyar_camera& c, double x, double y, double z) {
    const double point_m[3] = {x, y, z};
    double px[2] = {7, 7};
    const handyar_status status = handyar_project(&c, point_m, px);
    EXPECT_EQ(px[0] == 7, status != HANDYAR_OK) << "a refused point has no pixel";
    return status;
  };
  EXPECT_EQ(project(camera, 0, 0, 1), HANDYAR_OK);
  EXPECT_EQ(project(camera, nan, 0, 1), HANDYAR_BAD_ARGUMENT);
  EXPECT_EQ(project(camera, 0, nan, 1), HANDYAR_BAD_ARGUMENT);
  EXPECT_EQ(project(camera, 0, 0, nan), HANDYAR_BAD_ARGUMENT);
  EXPECT_EQ(project(camera, 0, 0, infinity), HANDYAR_BAD_ARGUMENT);
  EXPECT_EQ(project(camera, 1, 0, 1e-310), HANDYAR_BAD_ARGUMENT);
  for (double handyar_camera::*value : {&handyar_camera::fx_px, &handyar_camera::cy_px}) {
    handyar_camera bad = camera;
    bad.*value = nan;
    EXPECT_EQ(project(bad, 0, 0, 1), HANDYAR_BAD_ARGUMENT);
  }
  handyar_camera bad = camera;
  bad.distortion[4] = nan;
  EXPECT_EQ(project(bad, 0, 0, 1), HANDYAR_BAD_ARGUMENT);
  bad = camera;
  bad.width_px = 0;
  EXPECT_EQ(project(bad, 0, 0, 1), HANDYAR_BAD_ARGUMENT);
  for (const double fov_rad : {nan, infinity, 0.0, 4.0, 1e-310})
    EXPECT_EQ(handyar_camera_from_field_of_view(640, 480, fov_rad, &bad), HANDYAR_BAD_ARGUMENT);
}

}  // namespace
}  // namespace handyar
