// SPDX-License-Identifier: MIT
#include "handyar/tracker.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "hand_film.hpp"
#include "handyar/stages/evidence.hpp"

namespace handyar {
namespace {

using test::deg;
using test::Film;
using test::Picture;

/// What every result must keep, whatever was seen.
void expect_consistent(const TrackResult& r) {
  EXPECT_EQ(r.status, FrameStatus::ok);
  if (r.state == State::tracking) {
    EXPECT_TRUE(r.layout && r.face && r.pose && r.raw_pose);
  } else {
    EXPECT_FALSE(r.pose || r.raw_pose || r.doubtful);
  }
}

double rotation_error_rad(const Film& film) {
  return test::rotation_error_rad(film.T_camera_hand, film.result.pose->T_camera_hand);
}

class TrackerAt : public testing::TestWithParam<int> {};

TEST_P(TrackerAt, TracksWithinATenthOfASecondAtAnyFrameRate) {
  Film film;
  film.fps = GetParam();
  EXPECT_LT(film.until(State::tracking, 1), 0.1);
  for (int i = 0; i < 10; ++i) {
    expect_consistent(film.next());
    ASSERT_EQ(film.result.state, State::tracking);
    EXPECT_EQ(film.result.layout, Layout::thumb_right);
    EXPECT_LT(film.worst_tip_px(), 1.5);
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
    rotation_rad = std::max(rotation_rad, rotation_error_rad(film));
    translation_m =
        std::max(translation_m,
                 test::translation_error_m(film.T_camera_hand, film.result.pose->T_camera_hand));
    tips_px = std::max(tips_px, film.worst_tip_px());
    mean_tips_px += film.mean_tip_px() / 40;
  }
  EXPECT_LT(rotation_rad, deg(1.5));
  EXPECT_LT(translation_m, 0.003);
  EXPECT_LT(mean_tips_px, 0.5);
  EXPECT_LT(tips_px, 1.5);
}

/// A hand that swings before a camera whose rows are read one after the other: the medians of the
/// rotation errors over two seconds, of a tracker that is told and of one that is not.
std::pair<double, double> errors_with_and_without_readout_rad() {
  constexpr double kTrue_s = 0.03, kFrame_s = 1.0 / 30;
  constexpr int kBands = 8, kFrames = 60, kFirst = 15;
  Film film;
  const Camera& camera = film.camera;
  Camera told = camera;
  told.readout_s = kTrue_s;
  std::array<HandTracker, 2> trackers{HandTracker(told, film.hand_model),
                                      HandTracker(camera, film.hand_model)};
  const auto pose_at = [&](double t_s) {
    Eigen::Isometry3d T = film.pose_at(t_s);
    T.translation().x() += 0.07 * std::sin(6 * t_s);
    return T;
  };
  Picture background(camera.width_px, camera.height_px);
  background.texture(24, "Film");
  const int rows = camera.height_px / kBands;
  std::array<std::vector<double>, 2> errors_rad;
  for (int i = 0; i < kFrames; ++i) {
    Picture picture = background;
    for (int band = 0; band < kBands; ++band)
      picture.paint(film.hand, camera,
                    pose_at(i * kFrame_s + ((band + 0.5) / kBands - 0.5) * kTrue_s),
                    test::kSkinColor, {band * rows, (band + 1) * rows});
    picture.add_noise(3, static_cast<std::uint32_t>(i + 1));
    for (int k = 0; k < 2; ++k) {
      const TrackResult& result = trackers[k].process(picture.view(), i * kFrame_s);
      if (i < kFirst || !result.pose) continue;
      errors_rad[k].push_back(
          test::rotation_error_rad(pose_at(i * kFrame_s), result.pose->T_camera_hand));
    }
  }
  for (std::vector<double>& all : errors_rad) {
    EXPECT_EQ(all.size(), std::size_t{kFrames - kFirst});
    std::nth_element(all.begin(), all.begin() + all.size() / 2, all.end());
  }
  const auto median = [](const std::vector<double>& all) { return all[all.size() / 2]; };
  return {median(errors_rad[0]), median(errors_rad[1])};
}

TEST(Tracker, ARollingShutterThatIsToldTurnsNoHand) {
  const auto [told_rad, untold_rad] = errors_with_and_without_readout_rad();
  EXPECT_LT(told_rad, deg(1.0));
  EXPECT_GT(untold_rad, 2 * told_rad);
}

TEST(Tracker, GoesThroughItsStates) {
  Film film;
  film.present = false;
  for (int i = 0; i < 5; ++i) {
    expect_consistent(film.next());
    EXPECT_EQ(film.result.state, State::searching);
  }
  film.present = true;
  EXPECT_LT(film.until(State::tracking, 1), 0.1);
  for (int i = 0; i < 20; ++i) film.next();
  film.present = false;
  EXPECT_LT(film.until(State::lost, 1), 0.5);
  expect_consistent(film.result);
  EXPECT_FALSE(film.tracker.predict(film.time_s + 0.01));
  EXPECT_EQ(film.tracker.mask().width, 0);
  for (int i = 0; i < 20; ++i) expect_consistent(film.next());
  film.present = true;
  EXPECT_LT(film.until(State::tracking, 1), 0.1);
  EXPECT_LT(film.worst_tip_px(), 1.5);
  film.present = false;
  EXPECT_LT(film.until(State::searching, 5), 5) << "gone for long: searched for anew";
}

TEST(Tracker, AFistIsLostAndNeverAPose) {
  Film film;
  ASSERT_LT(film.until(State::tracking, 1), 1);
  film.present = false;
  film.extra = [&](Picture& p) {
    const Eigen::Vector2d at = film.camera.project(film.T_camera_hand.translation());
    p.paint([&](const Eigen::Vector2d& px) { return (px - at).norm() - 60; }, 1);
  };
  EXPECT_LT(film.until(State::lost, 1), 0.5);
  for (int i = 0; i < 30; ++i) {
    expect_consistent(film.next());
    EXPECT_NE(film.result.state, State::tracking) << "frame " << i;
  }
  film.extra = {};
  film.present = true;
  EXPECT_LT(film.until(State::tracking, 1), 0.1);
}

TEST(Tracker, AHandTurnedOverWhileAwayIsFoundWithTheOtherLayout) {
  Film film;
  ASSERT_LT(film.until(State::tracking, 1), 1);
  film.present = false;
  for (int i = 0; i < 5; ++i) film.next();
  film.present = true;
  film.hand.appearance.layout = Layout::thumb_left;
  EXPECT_LT(film.until(State::tracking, 1), 0.2);
  for (int i = 0; i < 10; ++i) film.next();
  ASSERT_EQ(film.result.state, State::tracking);
  EXPECT_EQ(film.result.layout, Layout::thumb_left);
  EXPECT_EQ(film.tracker.hand().layout, Layout::thumb_left);
  EXPECT_LT(film.worst_tip_px(), 1.5);
  EXPECT_LT(rotation_error_rad(film), deg(3));
}

TEST(Tracker, APoseThatIsReadAnewIsDoubtfulAtFirst) {
  Film film;
  ASSERT_LT(film.until(State::tracking, 1), 1);
  for (int i = 0; i < 15; ++i) film.next();
  EXPECT_FALSE(film.result.doubtful);
  film.hand.appearance.layout = Layout::thumb_left;  // at once: what was believed was wrong
  int doubtful = 0, sound = 0;
  for (int i = 0; i < 30; ++i) {
    film.next();
    if (!film.result.pose || film.result.layout != Layout::thumb_left) continue;
    EXPECT_TRUE(film.result.doubtful || doubtful > 0) << "frame " << i;
    ++(film.result.doubtful ? doubtful : sound);
  }
  EXPECT_GT(sound, 10);
}

TEST(Tracker, AFrameThatDipsALittleLeavesThePoseSoundAndOneThatShowsNothingDoesNot) {
  for (const double noise : {28.0, 60.0}) {
    Film film;
    ASSERT_LT(film.until(State::tracking, 1), 1);
    for (int i = 0; i < 15; ++i) film.next();
    ASSERT_FALSE(film.result.doubtful);
    film.extra = [noise](Picture& p) { p.add_noise(noise, 1000); };
    film.next();
    ASSERT_EQ(film.result.state, State::tracking);
    EXPECT_LT(film.tracker.evidence().log_ratio, 5) << "no dip, so it tells nothing";
    EXPECT_EQ(film.result.doubtful, noise > 50);
    film.extra = {};
    for (int i = 0; i < 6; ++i) film.next();
    EXPECT_FALSE(film.result.doubtful) << "after " << noise;
  }
}

TEST(Tracker, AFingertipHiddenForAWhileKeepsThePose) {
  for (const int finger : {0, 2, 4}) {
    Film film;
    ASSERT_LT(film.until(State::tracking, 1), 1);
    for (int i = 0; i < 10; ++i) film.next();
    film.extra = [&](Picture& p) {  // a disc of the wall's colour before it
      const Eigen::Vector2d tip = film.true_tip_px(finger);
      p.paint([&](const Eigen::Vector2d& px) { return (px - tip).norm() - 25; }, 1,
              test::kWallColor);
    };
    for (int i = 0; i < 15; ++i) {
      expect_consistent(film.next());
      ASSERT_EQ(film.result.state, State::tracking) << finger << " frame " << i;
      EXPECT_LT(rotation_error_rad(film), deg(4)) << finger << " frame " << i;
    }
  }
}

TEST(Tracker, TheOutlineThatIsToldIsThatOfTheHandThatIsTold) {
  Film film;
  ASSERT_LT(film.until(State::tracking, 0.5), 0.5);
  double share = 0;
  for (int i = 0; i < 75; ++i) {  // what was given up is laid anew meanwhile
    film.next();
    const FrameEvidence& told = film.tracker.evidence();
    double sum = 0;
    for (const OutlinePoint& p : told.outline) sum += p.log_ratio;
    if (i == 0) share = told.log_ratio / sum;
    EXPECT_NEAR(told.log_ratio, share * sum, 1e-3 * told.log_ratio) << i;
  }
}

TEST(Tracker, AHandThatStopsWhileTheCameraPausesIsFollowedFromWhereItIs) {
  Film film;
  const double speed_m_s = 0.2;
  const auto show = [&](double x_m) {
    film.time_s += 1 / film.fps;
    ++film.frame;
    film.T_camera_hand = test::hand_at(0.45, deg(15), 0.2, {x_m, 0});
    film.result = film.tracker.process(film.picture().view(), film.time_s);
  };
  double x_m = -0.08;
  for (; x_m < 0.04; x_m += speed_m_s / film.fps) show(x_m);
  ASSERT_EQ(film.result.state, State::tracking);
  film.time_s += 1.0;
  for (int i = 0; i < 2; ++i) {
    show(x_m);
    EXPECT_EQ(film.result.state, State::tracking) << i;
    EXPECT_FALSE(film.result.doubtful) << i << ": another hand is taken for it";
    EXPECT_LT(film.worst_tip_px(), 8) << i;
  }
}

TEST(Tracker, FingersThatMoveLeaveThePalmsPoseAndAreReported) {
  Film film;
  ASSERT_LT(film.until(State::tracking, 1), 1);
  double worst_rad = 0, abduction_rad = 0;
  for (int i = 0; i < 90; ++i) {
    for (int f = 0; f < kFingerCount; ++f)
      film.hand.state.posture.abduction_rad[f] = 0.07 * std::sin(2 * film.time_s + 1.3 * f);
    film.next();
    ASSERT_TRUE(film.result.pose);
    worst_rad = std::max(worst_rad, rotation_error_rad(film));
    for (int f = 0; f < kFingerCount; ++f)
      abduction_rad += std::abs(film.result.fingers[f].abduction_rad -
                                film.hand.state.posture.abduction_rad[f]) /
                       (90 * kFingerCount);
  }
  EXPECT_LT(worst_rad, deg(4));
  EXPECT_LT(abduction_rad, deg(1.5)) << "of 2.6 deg in the mean that they move";
}

TEST(Tracker, AThumbThatBendsInThePalmPlaneIsFollowedAndReported) {
  for (const double bend_rad : {-0.3, 0.3}) {
    Film film;
    film.hand.state.posture.thumb_bend_rad = bend_rad;
    ASSERT_LT(film.until(State::tracking, 1), 1) << bend_rad;
    for (int i = 0; i < 15; ++i) film.next();
    ASSERT_TRUE(film.result.pose) << bend_rad;
    EXPECT_NEAR(film.result.thumb_bend_rad, bend_rad, deg(6));
    EXPECT_LT(film.worst_tip_px(), 4) << bend_rad;
    EXPECT_LT(rotation_error_rad(film), deg(4)) << bend_rad;
  }
}

TEST(Tracker, FingersSideBySideAreNoSmallerHand) {
  for (const double closing : {0.0, 0.4, 0.7, 0.9}) {
    Film film;
    film.hand_model = average_adult_hand();
    film.tracker = HandTracker(film.camera, film.hand_model);
    for (int f = 0; f < kFingerCount; ++f)
      film.hand.state.posture.abduction_rad[f] = closing * closing_rad()[f];
    ASSERT_LT(film.until(State::tracking, 1), 1) << closing;
    for (int i = 0; i < 15; ++i) film.next();
    ASSERT_TRUE(film.result.pose) << closing;
    const Eigen::Isometry3d& T = film.result.pose->T_camera_hand;
    EXPECT_LT(rotation_error_rad(film), deg(8)) << closing;
    const double size = relative_size(film.hand.state.figure);
    EXPECT_NEAR(size * T.translation().norm() / film.T_camera_hand.translation().norm(), 1, 0.1)
        << closing;
  }
}

TEST(Tracker, LearnsAnotherPersonsHand) {
  Film film;
  film.hand_model = average_adult_hand();
  film.tracker = HandTracker(film.camera, film.hand_model);
  film.hand.state.figure.head<4>() << 1.0, -1.2, 0.8, 1.0;
  film.tilt_rad = 0.6;
  const HandModel truth = hand_of_figure(
      {film.hand.state.figure, Eigen::MatrixXd::Identity(kFigureModes, kFigureModes)},
      Layout::thumb_right);
  // Shapes are compared: without a length the size is assumed.
  const auto error_m = [&](const HandModel& hand) {
    const double size = truth.span_m() / hand.span_m();
    return (size * hand.tips_m - truth.tips_m).topRows<2>().colwise().norm().mean();
  };
  ASSERT_LT(film.until(State::tracking, 1), 1);
  for (int i = 0; i < 240; ++i) film.next();
  EXPECT_EQ(film.result.state, State::tracking);
  EXPECT_LT(error_m(film.tracker.hand()), 0.6 * error_m(average_adult_hand()));
  EXPECT_TRUE(film.result.scale_assumed);
}

TEST(Tracker, AnAssumedSizeStaysWhateverShapeIsLearned) {
  for (const double slender : {-2.0, 2.0}) {
    Film film;
    film.hand_model = average_adult_hand();
    film.tracker = HandTracker(film.camera, film.hand_model);
    film.hand.state.figure.head<2>() << slender, 0;
    const double size = relative_size(film.hand.state.figure);
    ASSERT_LT(film.until(State::tracking, 1), 1);
    for (int i = 0; i < 120; ++i) {
      film.next();
      if (i < 15) continue;
      ASSERT_TRUE(film.result.pose) << i;
      const double distance_m = film.result.pose->T_camera_hand.translation().norm();
      EXPECT_NEAR(size * distance_m / film.T_camera_hand.translation().norm(), 1, 0.015) << i;
    }
    const FigureEstimate figure{.mean = film.hand.state.figure};
    const HandModel truth = hand_of_figure(figure, Layout::thumb_right);
    EXPECT_NEAR(size * film.tracker.hand().span_m() / truth.span_m(), 1, 0.03);
  }
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
    EXPECT_LT(film.worst_tip_px(), 2.5);
  }
}

class TrackerNeverTracks : public testing::TestWithParam<std::string> {};

TEST_P(TrackerNeverTracks, WhatIsNoOutstretchedHand) {
  const std::string& what = GetParam();
  Film film;
  film.textured = true;
  film.present = false;
  const auto paint = [&](auto distance, test::Bgr color = test::kSkinColor) {
    film.extra = [=](Picture& p) { p.paint(distance, 1, color); };
  };
  using V = Eigen::Vector2d;
  if (what == "face")
    paint([](const V& p) { return 90 * (V((p.x() - 320) / 90, (p.y() - 220) / 125).norm() - 1); });
  if (what == "square")
    paint([](const V& p) { return (p - V(320, 240)).cwiseAbs().maxCoeff() - 80; });
  if (what == "arm") paint([](const V& p) { return std::abs(p.x() + 2 * p.y() - 800) / 2.2 - 40; });
  if (what == "noise") film.noise = 60;
  if (what == "outline") {  // what lies inside is the room
    HandState state;
    state.T_camera_hand = test::hand_at(0.35, deg(5), deg(10));
    const HandView view(film.camera, state.T_camera_hand.translation());
    const Silhouette silhouette({}, state, view);
    paint([=](const V& p) {
      return std::abs(silhouette.distance_px(view.from_frame(p)) + 1.5f) - 1.5f;
    });
  }
  for (int i = 0; i < 30; ++i) {
    expect_consistent(film.next());
    ASSERT_NE(film.result.state, State::tracking) << "frame " << i;
  }
}
INSTANTIATE_TEST_SUITE_P(Scenes, TrackerNeverTracks,
                         testing::Values("empty", "face", "square", "arm", "noise", "outline"),
                         [](const auto& scene) { return scene.param; });

TEST(Tracker, TheMaskIsWhereTheHandIs) {
  Film film;
  ASSERT_LT(film.until(State::tracking, 1), 1);
  for (int i = 0; i < 10; ++i) film.next();
  const HandMask mask = film.tracker.mask();
  ASSERT_EQ(mask.width, 640);
  ASSERT_EQ(mask.height, 480);
  Picture black(640, 480, {0, 0, 0});
  black.paint(film.hand, film.camera, film.T_camera_hand, {255, 255, 255});
  int hand = 0, both = 0, more = 0;
  const double wrist_px =  // the mask ends there, the drawn arm does not
      film.camera.project(film.T_camera_hand * Eigen::Vector3d(0, -0.06, 0)).y();
  for (int y = 0; y < wrist_px; ++y)
    for (int x = 0; x < 640; ++x) {
      const bool is = black.at(x, y)[0] > 127, says = mask.data[y * mask.stride_bytes + x] != 0;
      hand += is;
      both += is && says;
      more += !is && says;
    }
  EXPECT_GT(both, 0.96 * hand);
  EXPECT_LT(more, 0.04 * hand);
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
  EXPECT_LT(test::rotation_error_rad(truth, predicted->T_camera_hand), deg(2));
  EXPECT_LT(test::translation_error_m(truth, predicted->T_camera_hand), 0.004);
  EXPECT_FALSE(film.tracker.predict(film.time_s + 10));
}

}  // namespace
}  // namespace handyar
