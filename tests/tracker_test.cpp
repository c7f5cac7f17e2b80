// SPDX-License-Identifier: MIT
#include "handyar/tracker.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "hand_film.hpp"

namespace handyar {
namespace {

using test::deg;
using test::Film;
using test::Picture;

int seen_tips(const TrackResult& r) {
  return static_cast<int>(std::ranges::count_if(r.tips, [](const Tip& t) { return t.seen; }));
}

/// What every result must keep, whatever was seen.
void expect_consistent(const TrackResult& r) {
  EXPECT_EQ(r.status, FrameStatus::ok);
  EXPECT_EQ(r.layout.has_value(), r.state == State::acquiring || r.state == State::tracking);
  if (r.state == State::tracking) {
    EXPECT_TRUE(r.raw_pose.has_value());
    EXPECT_GE(seen_tips(r), 4);
  } else {
    EXPECT_FALSE(r.pose.has_value());
    EXPECT_FALSE(r.raw_pose.has_value());
  }
  if (!r.layout) {
    EXPECT_EQ(seen_tips(r), 0);
  }
}

class TrackerAt : public testing::TestWithParam<int> {};

TEST_P(TrackerAt, AcquiresWithinTheSameTimeAtAnyFrameRate) {
  Film film;
  film.fps = GetParam();
  const double acquired_s = film.until(State::tracking, 1);
  EXPECT_GT(acquired_s, 0.2) << "believed too soon";
  EXPECT_LT(acquired_s, 0.42);
  for (int i = 0; i < 10; ++i) {
    expect_consistent(film.next());
    EXPECT_EQ(film.result.state, State::tracking);
    EXPECT_EQ(film.result.layout, Layout::thumb_right);
    EXPECT_LT(film.worst_tip_px(), 4.5);
  }
}
INSTANTIATE_TEST_SUITE_P(FramesPerSecond, TrackerAt, testing::Values(15, 30, 60));

TEST(Tracker, PoseAgainstExactTruth) {
  Film film;
  film.textured = true;
  ASSERT_LT(film.until(State::tracking, 1), 1);
  double rotation_rad = 0, translation_m = 0, tips_px = 0, mean_tips_px = 0;
  for (int i = 0; i < 40; ++i) {
    film.next();
    ASSERT_TRUE(film.result.pose) << "frame " << film.frame;
    const Eigen::Isometry3d& T = film.result.pose->T_camera_hand;
    rotation_rad = std::max(rotation_rad, test::rotation_error_rad(film.T_camera_hand, T));
    translation_m = std::max(translation_m, test::translation_error_m(film.T_camera_hand, T));
    tips_px = std::max(tips_px, film.worst_tip_px());
    mean_tips_px += film.mean_tip_px() / 40;
  }
  RecordProperty("rotation_deg", std::to_string(rotation_rad / deg(1)));
  RecordProperty("translation_mm", std::to_string(1e3 * translation_m));
  RecordProperty("tips_px", std::to_string(tips_px));
  RecordProperty("mean_tips_px", std::to_string(mean_tips_px));
  EXPECT_LT(rotation_rad, deg(5));
  EXPECT_LT(translation_m, 0.009);
  EXPECT_LT(mean_tips_px, 1.5);
  EXPECT_LT(tips_px, 5);
}

TEST(Tracker, GoesThroughItsStates) {
  Film film;
  film.present = false;
  for (int i = 0; i < 5; ++i) {
    expect_consistent(film.next());
    EXPECT_EQ(film.result.state, State::searching);
  }
  film.present = true;
  EXPECT_LT(film.until(State::acquiring, 0.2), 0.2 + 1e-6);
  const double first_s = film.until(State::tracking, 1);
  ASSERT_LT(first_s, 0.5);
  for (int i = 0; i < 20; ++i) film.next();
  film.present = false;
  film.next();
  expect_consistent(film.result);
  EXPECT_EQ(film.result.state, State::lost);
  EXPECT_FALSE(film.tracker.predict(film.time_s + 0.01));
  EXPECT_TRUE(film.tracker.contour_px().empty());
  EXPECT_EQ(film.tracker.mask().width, 0);
  for (int i = 0; i < 20; ++i) expect_consistent(film.next());
  film.present = true;
  const double again_s = film.until(State::tracking, 1);
  EXPECT_LT(again_s, 0.3);
  EXPECT_LT(again_s, first_s) << "what is known of the hand speeds it up";
  EXPECT_LT(film.worst_tip_px(), 1.5);
  double mean_px = 0;  // of the worst tip: that of one frame says little
  for (int i = 0; i < 20; ++i, film.next()) mean_px += film.worst_tip_px() / 20;
  EXPECT_LT(mean_px, 1.5);
}

TEST(Tracker, AHandGoneForLongIsSearchedForAnew) {
  Film film;
  ASSERT_LT(film.until(State::tracking, 1), 1);
  film.present = false;
  EXPECT_LT(film.until(State::searching, 4), 4);
}

TEST(Tracker, AFistIsLostAndNeverAPose) {
  Film film;
  ASSERT_LT(film.until(State::tracking, 1), 1);
  for (int i = 0; i < 10; ++i) {  // the fingers fold within a third of a second
    film.hand.fold.fill((i + 1) / 10.0);
    film.next();
  }
  for (int i = 0; i < 30; ++i) {
    expect_consistent(film.next());
    EXPECT_EQ(film.result.state, State::lost) << "frame " << i;
  }
  film.hand.fold.fill(0);
  EXPECT_LT(film.until(State::tracking, 1), 0.4);
}

TEST(Tracker, TheOtherFaceIsFoundWithTheOtherLayout) {
  Film film;
  ASSERT_LT(film.until(State::tracking, 1), 1);
  film.present = false;  // edge on: nothing to see
  for (int i = 0; i < 5; ++i) film.next();
  film.present = true;
  film.hand.layout = Layout::thumb_left;
  EXPECT_LT(film.until(State::tracking, 1), 0.4);
  for (int i = 0; i < 10; ++i) {
    expect_consistent(film.next());
    EXPECT_EQ(film.result.layout, Layout::thumb_left);
    EXPECT_EQ(film.tracker.hand().layout, Layout::thumb_left);
    EXPECT_LT(film.worst_tip_px(), 2.0);
  }
  ASSERT_TRUE(film.result.pose);
  EXPECT_LT(test::rotation_error_rad(film.T_camera_hand, film.result.pose->T_camera_hand), deg(5));
}

TEST(Tracker, OneTipHiddenForAFewFramesKeepsThePose) {
  for (const int finger : {1, 2, 4}) {
    Film film;
    ASSERT_LT(film.until(State::tracking, 1), 1);
    for (int i = 0; i < 10; ++i) film.next();
    film.hand.fold[finger] = 1;
    for (int i = 0; i < 4; ++i) {
      expect_consistent(film.next());
      EXPECT_EQ(film.result.state, State::tracking) << finger << " frame " << i;
      EXPECT_TRUE(film.result.pose);
      EXPECT_FALSE(film.result.tips[finger].seen);
      EXPECT_LT(film.worst_tip_px(), 4.5);
    }
    film.hand.fold[finger] = 0;
    film.next();
    film.next();
    EXPECT_EQ(film.result.state, State::tracking);
    EXPECT_EQ(seen_tips(film.result), 5);
  }
}

TEST(Tracker, FourFingersForLongAreNoOutstretchedHand) {
  Film film;
  ASSERT_LT(film.until(State::tracking, 1), 1);
  film.hand.fold[2] = 1;
  EXPECT_LT(film.until(State::lost, 0.5), 0.5);
}

TEST(Tracker, ALargerObjectOfSkinColourDoesNotStealTheTrack) {
  Film film;
  ASSERT_LT(film.until(State::tracking, 1), 1);
  for (int i = 0; i < 20; ++i) {
    const double edge = 640 - 8.0 * i;  // comes in from the right, as high as the picture
    film.extra = [edge](Picture& p) {
      p.paint([edge](const Eigen::Vector2d& px) { return edge - px.x(); }, 1);
    };
    film.next();
    ASSERT_EQ(film.result.state, State::tracking) << "edge at " << edge;
    EXPECT_LT(film.worst_tip_px(), 4.5);
  }
}

/// Whether a hand with a half bent finger, so not quite like others, is tracked.
bool tracks_a_bent_finger(const Config& config) {
  Film film(config);
  film.textured = true;
  film.hand.fold[4] = 0.5;
  return film.until(State::tracking, 1) < 1;
}

TEST(Tracker, AHandUnlikeOthersIsBelievedWhereReadingsAgree) {
  Config by_likeness_alone;
  by_likeness_alone.search.enough_views = 1000;
  EXPECT_FALSE(tracks_a_bent_finger(by_likeness_alone));
  EXPECT_TRUE(tracks_a_bent_finger({}));
}

/// Whether a hand is tracked whose tips are higher and lower than its model has them, in turn.
bool tracks_a_hand_off_its_model(double off_m, const Config& config) {
  Film film(config);
  film.textured = true;
  for (int f = 0; f < kFingerCount; ++f)
    film.hand_model.tips_m(1, f) += f % 2 == 0 ? off_m : -off_m;
  film.tracker = HandTracker(film.camera, film.hand_model, config);
  return film.until(State::tracking, 1) < 1;
}

TEST(Tracker, AHandJustFoundFitsItsModelBetterThanOneThatIsFollowed) {
  Config as_one_followed;
  as_one_followed.acquisition.new_residual_m = as_one_followed.acquisition.max_residual_m;
  EXPECT_TRUE(tracks_a_hand_off_its_model(0.004, {}));
  EXPECT_FALSE(tracks_a_hand_off_its_model(0.0059, {}));
  EXPECT_TRUE(tracks_a_hand_off_its_model(0.0059, as_one_followed));
  EXPECT_FALSE(tracks_a_hand_off_its_model(0.007, as_one_followed));
}

/// In how many of 60 frames the thumb of a new hand is read at the far end of a bar that it
/// touches, which has its colour.
int read_at_the_end_of_the_bar(const Config& config) {
  Film film(config);
  film.textured = true;
  film.extra = [&film](Picture& p) {
    const Eigen::Vector2d thumb = film.true_tip_px(0), end = thumb + Eigen::Vector2d(60, 0);
    p.paint([&](const Eigen::Vector2d& px) { return test::capsule_distance(px, thumb, end, 9); },
            1);
  };
  int misread = 0;
  for (int i = 0; i < 60; ++i)
    misread += film.next().state == State::tracking && film.worst_tip_px() > 40;
  return misread;
}

TEST(Tracker, NoFingerIsMuchLongerThanTheModelHasIt) {
  Config of_any_length;
  of_any_length.shape.odd_tip_m = 1;
  EXPECT_GT(read_at_the_end_of_the_bar(of_any_length), 30);
  EXPECT_EQ(read_at_the_end_of_the_bar({}), 0);
}

/// Of which noise films are made that count together: what a single one shows hangs on its last
/// bits.
constexpr std::array kNoises = {2, 3, 4, 5, 6};

/// In how many of 8 frames the thumb of a hand that is hardly known yet is read at the far end of
/// what it touches and has its colour.
int misread_thumbs(const Config& config, double noise) {
  Film film(config);
  film.noise = noise;
  EXPECT_LT(film.until(State::tracking, 1), 1);
  film.extra = [&film](Picture& p) {
    const Eigen::Vector2d thumb = film.true_tip_px(0), end = thumb + Eigen::Vector2d(80, 0);
    p.paint([&](const Eigen::Vector2d& px) { return test::capsule_distance(px, thumb, end, 12); },
            1);
  };
  int misread = 0;
  for (int i = 0; i < 8; ++i) {
    film.next();
    misread += film.worst_tip_px() > 40;
  }
  return misread;
}

TEST(Tracker, ANewHandHardlyGrowsTogetherWithWhatItTouches) {
  Config by_leap, at_any_leap;
  by_leap.shape.odd_tip_m = at_any_leap.shape.odd_tip_m = 1;
  at_any_leap.shape.max_leap = 10;
  int misread = 0, misread_at_any_leap = 0;
  for (const double noise : kNoises) {
    misread += misread_thumbs(by_leap, noise);
    misread_at_any_leap += misread_thumbs(at_any_leap, noise);
  }
  EXPECT_GT(misread_at_any_leap, misread + 10);
}

/// In how many of 60 frames of a camera in dim light, before a board of nearly its colour, a hand
/// is tracked and its tips are right.
int right_in_dim_light(const Config& config) {
  Film film(config);
  film.noise = 20;
  film.background.emplace(film.camera.width_px, film.camera.height_px);
  film.textured = true;
  film.background->paint([](const Eigen::Vector2d&) { return -1.0; }, 1, {130, 150, 190});
  int right = 0;
  for (int i = 0; i < 60; ++i)
    right += film.next().state == State::tracking && film.worst_tip_px() < 8;
  return right;
}

TEST(Tracker, AveragesColoursWhereTheyAreNoisy) {
  Config as_they_are;
  as_they_are.noise.tracked = as_they_are.noise.searched = 100;
  EXPECT_LT(right_in_dim_light(as_they_are), 10);
  EXPECT_GT(right_in_dim_light({}), 45);
}

TEST(Tracker, TheNailsOfADarkHandBelongToIt) {
  Film film;
  film.present = false;
  film.textured = true;
  film.extra = [&film](Picture& p) {
    p.paint(film.hand, film.camera, film.T_camera_hand, {42, 46, 66});
    const HandModel seen = film.hand_model.for_layout(film.hand.layout);
    const double radius_px = 0.0075 * film.camera.fx_px / film.T_camera_hand.translation().z();
    for (int f = 0; f < kFingerCount; ++f) {
      const auto below_tip_px = [&](double m) -> Eigen::Vector2d {
        const Eigen::Vector3d at = seen.tips_m.col(f) - m * seen.directions().col(f);
        return film.camera.project(film.T_camera_hand * at);
      };
      const Eigen::Vector2d from = below_tip_px(0.012), to = below_tip_px(0.0075);
      p.paint(
          [&](const Eigen::Vector2d& px) {
            return test::capsule_distance(px, from, to, radius_px);
          },
          1, {130, 120, 130});
    }
  };
  ASSERT_LT(film.until(State::tracking, 2), 2);
  for (int i = 0; i < 30; ++i) {
    film.next();
    EXPECT_EQ(film.result.state, State::tracking);
    EXPECT_LT(film.worst_tip_px(), 4.5);
  }
}

class TrackerNeverAcquires : public testing::TestWithParam<std::string> {};

TEST_P(TrackerNeverAcquires, WhatIsNoOutstretchedHand) {
  const std::string& what = GetParam();
  Film film;
  film.textured = true;
  film.present = false;
  const auto paint = [&](auto distance, test::Bgr color = test::kSkinColor) {
    film.extra = [=](Picture& p) { p.paint(distance, 1, color); };
  };
  using V = Eigen::Vector2d;
  if (what == "fist" || what == "three_fingers" || what == "four_fingers") film.present = true;
  if (what == "fist") film.hand.make_fist();
  if (what == "three_fingers") film.hand.fold = {1, 0, 0, 0, 1};
  if (what == "four_fingers") film.hand.fold = {1, 0, 0, 0, 0};
  if (what == "face")
    paint([](const V& p) { return 90 * (V((p.x() - 320) / 90, (p.y() - 220) / 125).norm() - 1); });
  if (what == "arm")
    paint([](const V& p) { return test::capsule_distance(p, {0, 500}, {400, 200}, 40); });
  if (what == "noise") film.noise = 60;
  if (what == "comb")
    paint([](const V& p) {
      double d = test::capsule_distance(p, {180, 320}, {460, 320}, 30);
      for (const int k : {0, 1, 2, 3, 4})
        d = std::min(d,
                     test::capsule_distance(p, {180.0 + 70 * k, 320}, {180.0 + 70 * k, 150}, 14));
      return d;
    });
  for (int i = 0; i < 30; ++i) {
    expect_consistent(film.next());
    ASSERT_NE(film.result.state, State::tracking) << "frame " << i;
  }
}
INSTANTIATE_TEST_SUITE_P(Scenes, TrackerNeverAcquires,
                         testing::Values("empty", "fist", "three_fingers", "four_fingers", "face",
                                         "arm", "comb", "noise"),
                         [](const auto& scene) { return scene.param; });

TEST(Tracker, AtHalfResolutionEverythingIsInInputPixels) {
  Config config;
  config.half_resolution = true;
  Film film(config);
  ASSERT_LT(film.until(State::tracking, 1), 0.5);
  for (int i = 0; i < 10; ++i) {
    expect_consistent(film.next());
    ASSERT_EQ(film.result.state, State::tracking);
    EXPECT_LT(film.worst_tip_px(), 5);
    EXPECT_LT(test::rotation_error_rad(film.T_camera_hand, film.result.pose->T_camera_hand),
              deg(7));
  }
  EXPECT_EQ(film.tracker.mask().step_px, 2);
}

TEST(Tracker, ContourAndMaskAreWhereTheHandIs) {
  Film film;
  ASSERT_LT(film.until(State::tracking, 1), 1);
  const HandMask mask = film.tracker.mask();
  ASSERT_GT(mask.width, 0);
  const auto at = [&](const Eigen::Vector2d& px) {
    const int u = (int(std::lround(px.x())) - mask.x0_px) / mask.step_px;
    const int v = (int(std::lround(px.y())) - mask.y0_px) / mask.step_px;
    return u >= 0 && v >= 0 && u < mask.width && v < mask.height &&
           mask.data[v * mask.stride_bytes + u] != 0;
  };
  EXPECT_TRUE(at(film.camera.project(film.T_camera_hand * Eigen::Vector3d(0, -0.03, 0))));
  EXPECT_FALSE(at(film.true_tip_px(2) - Eigen::Vector2d(0, 8)));
  const auto contour = film.tracker.contour_px();
  ASSERT_GT(contour.size(), 500u);
  for (int f = 0; f < kFingerCount; ++f) {
    double nearest = 1e9;
    for (const auto& p : contour)
      nearest = std::min(nearest, (p.cast<double>() - film.true_tip_px(f)).norm());
    EXPECT_LT(nearest, 2.5) << kFingerNames[f];
  }
}

TEST(Tracker, AGloveIsFoundByItsShapeAndItsColoursAreGivenBack) {
  const auto wear = [](Film& film, const test::Bgr& color) {
    film.present = false;
    film.textured = true;
    film.extra = [&film, color](Picture& p) {
      p.paint(film.hand, film.camera, film.T_camera_hand, color);
    };
  };
  Film film;
  wear(film, {200, 90, 40});
  EXPECT_TRUE(film.tracker.learned_colors().empty());
  ASSERT_LT(film.until(State::tracking, 2), 2);
  for (int i = 0; i < 15; ++i) film.next();
  EXPECT_EQ(film.result.state, State::tracking);
  EXPECT_LT(film.worst_tip_px(), 4.5);
  const SkinColors colors = film.tracker.learned_colors();
  double glove = 0, total = 0;
  for (const SkinColors::Entry& e : colors.entries) {
    const Eigen::Vector3d away = rgb_of(e.bin) - Eigen::Vector3d(40, 90, 200);
    if (away.cwiseAbs().maxCoeff() < 36) glove += e.share;
    total += e.share;
  }
  EXPECT_NEAR(total, 1, 1e-3);
  EXPECT_GT(glove, 0.93) << "but for edges";

  Config config;
  config.skin.personal = colors;
  Film again(config);
  wear(again, {200, 90, 40});
  EXPECT_LT(again.until(State::tracking, 1), 0.42) << "known from the first frame on";
  again.tracker.reset();
  EXPECT_LT(again.until(State::tracking, 1), 0.42) << "and still known after a reset";
  film.tracker.reset();
  EXPECT_TRUE(film.tracker.learned_colors().empty());
}

struct Frames {
  int tracked = 0, right = 0;
};

/// Adds in how many of 30 frames a hand is tracked, and all its tips rightly, that from one frame
/// to the next takes on the colours of the room behind it, a half of it darker, a half lighter.
void track_in_the_rooms_colors(const Config& config, double noise, Frames& frames) {
  Film film(config);
  film.noise = noise;
  film.textured = true;
  EXPECT_LT(film.until(State::tracking, 1), 1);
  for (int i = 0; i < 15; ++i) film.next();
  film.present = false;
  film.extra = [&film](Picture& p) {
    const Picture room = p;
    p.paint(film.hand, film.camera, film.T_camera_hand);
    for (int y = 0; y < p.height(); ++y)
      for (int x = 0; x < p.width(); ++x) {
        if (std::equal(room.at(x, y), room.at(x, y) + 3, p.at(x, y))) continue;
        const int light = 2 * x + y < 2 * 330 + 200 ? -50 : 50;
        for (int c = 0; c < 3; ++c)
          p.at(x, y)[c] = static_cast<std::uint8_t>(std::clamp(room.at(x, y)[c] + light, 0, 255));
      }
  };
  for (int i = 0; i < 30; ++i) {
    expect_consistent(film.next());
    if (film.result.state != State::tracking) continue;
    ++frames.tracked;
    frames.right += film.worst_tip_px() < 20;
  }
  film.extra = {};
  EXPECT_LT(film.until(State::lost, 0.2), 0.2) << "there is no outline any more";
  for (int i = 0; i < 30; ++i) EXPECT_NE(film.next().state, State::tracking);
}

TEST(Tracker, FollowsTheOutlineWhereColoursTellNothing) {
  Config by_color_alone;
  by_color_alone.acquisition.max_colorless_s = 0;
  Frames frames, colored;
  for (const double noise : kNoises) {
    track_in_the_rooms_colors({}, noise, frames);
    track_in_the_rooms_colors(by_color_alone, noise, colored);
  }
  EXPECT_GT(frames.right, colored.tracked + 50);
  EXPECT_GT(frames.right, 0.75 * frames.tracked);
}

TEST(Tracker, HasRoomForFramesOfAnyShape) {
  for (const bool half : {false, true})
    for (const auto& [width, height] :
         {std::pair{4096, 120}, {120, 4096}, {161, 120}, {901, 900}, {1801, 1013}}) {
      Config config;
      config.half_resolution = half;
      const Camera camera = Camera::from_field_of_view(width, height);
      HandTracker tracker(camera, average_adult_hand(), config);
      Picture picture(width, height);
      picture.texture(24, "Room");
      for (int i = 1; i <= 3; ++i) {
        const TrackResult result = tracker.process(picture.view(), i / 30.0);
        EXPECT_EQ(result.status, FrameStatus::ok);
        EXPECT_NE(result.state, State::tracking);
      }
    }
}

TEST(Tracker, PredictsThePoseForDisplay) {
  Film film;
  EXPECT_FALSE(film.tracker.predict(0.01));
  ASSERT_LT(film.until(State::tracking, 1), 1);
  for (int i = 0; i < 30; ++i) film.next();
  const double ahead_s = film.time_s + 0.02;
  const auto predicted = film.tracker.predict(ahead_s);
  ASSERT_TRUE(predicted);
  EXPECT_DOUBLE_EQ(predicted->time_s, ahead_s);
  const Eigen::Isometry3d truth = film.pose_at(ahead_s);
  EXPECT_LT(test::rotation_error_rad(truth, predicted->T_camera_hand), deg(4));
  EXPECT_LT(test::translation_error_m(truth, predicted->T_camera_hand), 0.008);
  EXPECT_FALSE(film.tracker.predict(film.time_s + 10));
}

}  // namespace
}  // namespace handyar
