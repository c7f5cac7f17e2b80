// SPDX-License-Identifier: MIT
// Fingers that fold, told from a drawn hand with exact truth.
#include "handyar/gesture.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "hand_film.hpp"

namespace handyar {
namespace {

using test::Film;

using test::between;
using test::kFist;

/// The thumb in the palm, not quite as the tracker has it.
constexpr Posture kFour = {{-0.85, 0.02, 0, 0, -0.02}, {0.9, 0.05, 0, -0.04, 0.03}};

// An object on the palm may stray by so much while fingers move.
constexpr double kMostMoved_px = 8;

/// What was told while a hand went through its postures.
struct Told {
  std::vector<GestureEvent> events;
  std::vector<double> times_s;  ///< of the events
  double farthest_px = 0;       ///< of the palm's place, told or held, from its true one
  int without_place = 0;        ///< frames
  int poses_while_folded = 0;   ///< frames that claim a pose of a hand that is wholly folded
};

class GesturesAt : public testing::TestWithParam<int> {
 protected:
  GesturesAt() { film.fps = GetParam(); }

  void play(const Posture& from, const Posture& to, double seconds) {
    const double start_s = film.time_s;
    while (film.time_s < start_s + seconds - 0.5 / film.fps) {
      const double share = seconds > 0 ? (film.time_s + 1 / film.fps - start_s) / seconds : 1;
      film.hand.state.posture = between(from, to, std::min(share, 1.0));
      look(false);
    }
  }
  void hold(const Posture& posture, double seconds, bool folded) {
    film.hand.state.posture = posture;
    const double start_s = film.time_s;
    while (film.time_s < start_s + seconds - 0.5 / film.fps) look(folded);
  }
  void look(bool folded) {
    const TrackResult& r = film.next();
    if (r.gesture_event) {
      told.events.push_back(*r.gesture_event);
      told.times_s.push_back(film.time_s);
    }
    told.poses_while_folded += folded && r.pose;
    EXPECT_NE(r.pose.has_value(), r.state != State::tracking);
    EXPECT_FALSE(r.pose && r.held_pose);
    const auto& place = r.pose ? r.pose : r.held_pose;
    if (!place) {
      ++told.without_place;
      return;
    }
    const Eigen::Vector3d palm_m = film.hand_model.palm_centre_m();
    const Eigen::Vector2d told_px = film.camera.project(place->T_camera_hand * palm_m),
                          true_px = film.camera.project(film.T_camera_hand * palm_m);
    told.farthest_px = std::max(told.farthest_px, (told_px - true_px).norm());
  }

  Film film;
  Told told;
};

TEST_P(GesturesAt, AFistGrabsAndReleases) {
  ASSERT_LT(film.until(State::tracking, 1), 1);
  hold({}, 0.5, false);
  play({}, kFist, 0.3);
  const double closed_s = film.time_s;
  hold(kFist, 0.2, false);
  hold(kFist, 0.8, true);
  EXPECT_EQ(film.result.gesture, Gesture::fist);
  play(kFist, {}, 0.3);
  const double opened_s = film.time_s;
  hold({}, 0.5, false);
  ASSERT_EQ(told.events, (std::vector{GestureEvent::grab, GestureEvent::release}));
  EXPECT_LT(told.times_s[0], closed_s + 0.2);
  EXPECT_LT(told.times_s[1], opened_s + 0.2);
  EXPECT_EQ(told.poses_while_folded, 0);
  EXPECT_LT(told.farthest_px, kMostMoved_px);
  EXPECT_LE(told.without_place, 0.2 * film.fps);
  EXPECT_EQ(film.result.state, State::tracking);
  EXPECT_EQ(film.result.gesture, Gesture::open);
  EXPECT_LT(film.worst_tip_px(), 1.5);
}

TEST_P(GesturesAt, AThumbFoldedInClicksOnce) {
  ASSERT_LT(film.until(State::tracking, 1), 1);
  hold({}, 0.5, false);
  play({}, kFour, 0.3);
  const double folded_s = film.time_s;
  hold(kFour, 0.2, false);
  hold(kFour, 0.4, true);
  EXPECT_EQ(film.result.gesture, Gesture::four);
  play(kFour, {}, 0.3);
  hold({}, 0.5, false);
  ASSERT_EQ(told.events, std::vector{GestureEvent::click});
  EXPECT_LT(told.times_s[0], folded_s + 0.2);
  EXPECT_EQ(told.poses_while_folded, 0);
  EXPECT_LT(told.farthest_px, kMostMoved_px);
  EXPECT_LE(told.without_place, 0.1 * film.fps);
  EXPECT_EQ(film.result.state, State::tracking);
  EXPECT_EQ(film.result.gesture, Gesture::open);
}

TEST_P(GesturesAt, TheOtherHandAndTheBackOfAHandDoToo) {
  film.hand.appearance = {Face::back, Layout::thumb_left};
  ASSERT_LT(film.until(State::tracking, 1), 1);
  hold({}, 0.5, false);
  play({}, kFist, 0.3);
  hold(kFist, 0.6, false);
  play(kFist, {}, 0.3);
  hold({}, 0.5, false);
  play({}, kFour, 0.3);
  hold(kFour, 0.6, false);
  play(kFour, {}, 0.3);
  hold({}, 0.5, false);
  EXPECT_EQ(told.events,
            (std::vector{GestureEvent::grab, GestureEvent::release, GestureEvent::click}));
  EXPECT_LT(told.farthest_px, kMostMoved_px);
}

TEST_P(GesturesAt, AFistThatOpensAllButItsThumbIsLetGo) {
  ASSERT_LT(film.until(State::tracking, 1), 1);
  hold({}, 0.5, false);
  play({}, kFist, 0.3);
  hold(kFist, 0.5, false);
  play(kFist, kFour, 0.3);
  hold(kFour, 0.5, false);
  EXPECT_EQ(film.result.gesture, Gesture::four);
  EXPECT_EQ(told.events, (std::vector{GestureEvent::grab, GestureEvent::release}));
}

TEST_P(GesturesAt, AFistThatGoesIsLetGo) {
  ASSERT_LT(film.until(State::tracking, 1), 1);
  hold({}, 0.5, false);
  play({}, kFist, 0.3);
  hold(kFist, 0.5, false);
  ASSERT_EQ(told.events, std::vector{GestureEvent::grab});
  film.present = false;
  told = {};
  for (int i = 0; i < 0.7 * film.fps; ++i) {
    const TrackResult& r = film.next();
    if (r.gesture_event) told.events.push_back(*r.gesture_event);
    EXPECT_NE(r.state, State::tracking);
  }
  EXPECT_EQ(told.events, std::vector{GestureEvent::release});
  EXPECT_FALSE(film.result.held_pose);
  EXPECT_EQ(film.result.gesture, Gesture::open);
}

TEST_P(GesturesAt, AHandThatMovesItsFingersOrGoesTellsNothing) {
  film.textured = true;
  ASSERT_LT(film.until(State::tracking, 1), 1);
  for (int i = 0; i < 2 * film.fps; ++i) {
    for (int f = 0; f < kFingerCount; ++f)
      film.hand.state.posture.abduction_rad[f] = 0.1 * std::sin(3 * film.time_s + 1.3 * f);
    film.next();
    EXPECT_FALSE(film.result.gesture_event);
  }
  film.present = false;
  for (int i = 0; i < film.fps; ++i) EXPECT_FALSE(film.next().gesture_event);
}

INSTANTIATE_TEST_SUITE_P(FramesPerSecond, GesturesAt, testing::Values(15, 30, 60, 120));

}  // namespace
}  // namespace handyar
