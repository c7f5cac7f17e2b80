// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "hand_film.hpp"

namespace handyar::test {
namespace {

/// A right palm as in Film, and beside it a left one of the same person that moves sideways.
struct TwoHands : testing::Test {
  TwoHands() {
    film.tilt_rad = deg(8);
    left.appearance = {Face::palm, Layout::thumb_left};
    film.extra = [this](Picture& p) {
      if (left_present) p.paint(left, film.camera, left_pose());
    };
    share_view(film.tracker, second);
  }

  Eigen::Isometry3d left_pose() const { return hand_at(0.36, deg(10), -0.4, {left_x_m, -0.02}); }
  void next() {
    film.next();
    result = second.process(film.picture().view(), film.time_s);
  }
  void until_both(double limit_s) {
    for (const double end_s = film.time_s + limit_s; film.time_s < end_s;) {
      next();
      if (film.result.pose && result.pose) return;
    }
    FAIL() << "not both within " << limit_s << " s";
  }
  double left_off_px() const {
    const PosedFigure posed =
        pose_fingers(make_figure(left.state.figure, left.appearance.face, left.appearance.layout),
                     left.state.posture);
    double worst = 0;
    for (int f = 0; f < kFingerCount; ++f)
      worst = std::max(
          worst, (result.tips[f].px - film.camera.project(left_pose() * posed.tips_m.col(f).eval()))
                     .norm());
    return worst;
  }

  Film film;
  HandTracker second{film.camera, film.hand_model};
  DrawnHand left;
  bool left_present = true;
  double left_x_m = 0.15;
  TrackResult result;
};

TEST_F(TwoHands, AreFollowedAtOnce) {
  film.present = true;
  left_x_m = 0.17;
  left_present = false;
  ASSERT_LT(film.until(State::tracking, 0.5), 0.5);
  left_present = true;
  until_both(0.5);
  for (int i = 0; i < 30; ++i) {
    next();
    ASSERT_TRUE(film.result.pose && result.pose) << i;
    EXPECT_EQ(film.result.layout, Layout::thumb_right);
    EXPECT_EQ(result.layout, Layout::thumb_left);
    EXPECT_LT(film.worst_tip_px(), 6);
    EXPECT_LT(left_off_px(), 6);
  }
}

/// By how far the left hand moves in a frame, in millimetres: 0.15 to 0.4 m/s.
struct TwoHandsThatPass : TwoHands, testing::WithParamInterface<int> {};

TEST_P(TwoHandsThatPass, KeepTheirPlaces) {
  const double most_m = 0.001 * GetParam();
  left_x_m = 0.17;
  left_present = false;
  ASSERT_LT(film.until(State::tracking, 0.5), 0.5);
  left_present = true;
  until_both(0.5);
  for (const double to_m : {-0.17, 0.17}) {
    while (left_x_m != to_m) {
      left_x_m += std::clamp(to_m - left_x_m, -most_m, most_m);
      next();
    }
    until_both(0.6);
    EXPECT_EQ(film.result.layout, Layout::thumb_right);
    EXPECT_EQ(result.layout, Layout::thumb_left);
    EXPECT_LT(film.worst_tip_px(), 8);
    EXPECT_LT(left_off_px(), 8);
  }
}

INSTANTIATE_TEST_SUITE_P(Speeds, TwoHandsThatPass, testing::Values(5, 9, 13));

TEST_F(TwoHands, OneHandIsNeverTwo) {
  left_present = false;
  int both = 0, found = 0;
  for (int i = 0; i < 60; ++i) {
    next();
    found += film.result.pose.has_value() || result.pose.has_value();
    both += film.result.state != State::searching && result.state != State::searching;
  }
  EXPECT_GT(found, 50);
  EXPECT_EQ(both, 0);
}

TEST_F(TwoHands, AHandThatClosesAndOpensIsNotTakenByTheOther) {
  left_present = false;
  film.tilt_rad = deg(4);
  ASSERT_LT(film.until(State::tracking, 0.5), 0.5);
  for (double phase = 0; phase < 3; phase += 0.02) {  // thrice: to a fist, so for a while, open
    const double share = std::clamp(1.6 - 8 * std::abs(std::fmod(phase, 1.0) - 0.5), 0.0, 1.0);
    film.hand.state.posture = between({}, kFist, share);
    next();
    ASSERT_FALSE(result.pose) << phase;
    ASSERT_FALSE(result.held_pose) << phase;
  }
  EXPECT_EQ(film.result.state, State::tracking);
}

TEST_F(TwoHands, TheSecondsHandComesBackAlone) {
  left_x_m = 0.17;
  left_present = false;
  ASSERT_LT(film.until(State::tracking, 0.5), 0.5);
  left_present = true;
  until_both(0.5);
  for (int i = 0; i < 6; ++i) next();
  film.present = left_present = false;
  for (int i = 0; i < 20; ++i) next();
  ASSERT_EQ(film.result.state, State::lost);
  ASSERT_EQ(result.state, State::lost);
  left_present = true;
  for (int i = 0; i < 6; ++i) next();
  EXPECT_EQ(result.state, State::tracking);
  EXPECT_NE(film.result.state, State::tracking);
  EXPECT_LT(left_off_px(), 8);
}

TEST(ShareView, EndsWithEitherTracker) {
  Film film;
  {
    HandTracker gone(film.camera, film.hand_model);
    share_view(film.tracker, film.tracker);
    share_view(gone, film.tracker);  // so that film's would wait for the other to search
  }
  EXPECT_LT(film.until(State::tracking, 0.5), 0.5);
}

}  // namespace
}  // namespace handyar::test
