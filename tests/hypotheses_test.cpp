// SPDX-License-Identifier: MIT
#include "track/hypotheses.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "hand_film.hpp"

namespace handyar {
namespace {

using test::deg;

/// The ways to see a drawn hand of somebody unknown, begun where its fingers are.
struct Beginning {
  Beginning(const Config& config, double tilt_rad, float palm_log_odds = 0) {
    film.tilt_rad = tilt_rad;
    begin(config, palm_log_odds);
  }

  void begin(const Config& config, float palm_log_odds) {
    film.T_camera_hand = film.pose_at(0);
    candidate.layout = film.hand.appearance.layout;
    candidate.palm_log_odds = palm_log_odds;
    for (int f = 0; f < kFingerCount; ++f) {
      candidate.tips_px[f] = film.true_tip_px(f).cast<float>();
      candidate.roots_px[f] = film.true_root_px(f).cast<float>();
    }
    found = ways.begin(candidate, film.picture().view(), film.camera, Person(average_adult_hand()),
                       config, aligner);
  }

  test::Film film;
  HandCandidate candidate;
  Aligner aligner;
  Hypotheses ways;
  bool found = false;
};

TEST(Hypotheses, WaysThatAreNotDecidedBetweenAreTheDoubtOfThePose) {
  for (const double tilt_rad : {0.0, deg(10)}) {
    Beginning hand({}, tilt_rad);
    ASSERT_TRUE(hand.found);
    ASSERT_GE(hand.ways.size(), 2) << "palm and back of a hand seen from the front look alike";
    const Matrix6d spread = hand.ways.spread(false);
    EXPECT_GT(std::sqrt(spread.topLeftCorner<3, 3>().trace()), deg(1));
    EXPECT_GE(Eigen::SelfAdjointEigenSolver<Matrix6d>(spread).eigenvalues().minCoeff(), -1e-12);
    hand.ways.resume(hand.ways.best());
    EXPECT_LT(hand.ways.spread(false).norm(), 1e-20) << "one way is not in doubt";
  }
}

TEST(Hypotheses, TheFinderTellsPalmFromBackWhereTheOutlineDoesNot) {
  for (const float palm_log_odds : {-6.0f, 6.0f}) {
    const Beginning hand({}, 0, palm_log_odds);
    ASSERT_TRUE(hand.found);
    EXPECT_EQ(hand.ways.best().appearance.face, palm_log_odds > 0 ? Face::palm : Face::back);
  }
}

TEST(Hypotheses, TheFinderChangesItsMindAboutTheFaceAndAHandThatIsUndecidedStaysAsItWas) {
  Beginning hand({}, 0, 1);
  ASSERT_TRUE(hand.found);
  HandCandidate back = hand.candidate;
  back.palm_log_odds = -6;
  for (const Face expected : {Face::palm, Face::back}) {  // 4 nats a look; 2 must be led by
    hand.ways.expect(&back, hand.film.camera, 1, {});
    ASSERT_TRUE(
        hand.ways.follow(hand.film.picture().view(), hand.film.camera, 1.0 / 30, {}, hand.aligner));
    EXPECT_EQ(hand.ways.best().appearance.face, expected);
  }
}

TEST(Hypotheses, AThumbStaysWhereTheFinderSawItThoughSkinGoesOnBehindIt) {
  Beginning hand({}, deg(10));
  test::Film& film = hand.film;
  film.hand.state.posture.flexion_rad[0] = 0.8;  // it is seen shorter than at rest
  film.extra = [&](test::Picture& picture) {
    const Eigen::Vector2d tip = film.true_tip_px(0),
                          along = (tip - film.true_root_px(0)).normalized();
    picture.paint(
        [&](const Eigen::Vector2d& px) {
          const double goes_px = std::clamp((px - tip).dot(along), -8.0, 60.0);
          return (px - tip - goes_px * along).norm() - 10;
        },
        1);
  };
  hand.begin({}, 6);
  ASSERT_TRUE(hand.found);
  for (int frame = 0; frame < 6; ++frame) {  // until the finder looks again
    ASSERT_TRUE(hand.ways.follow(film.picture().view(), film.camera, 1.0 / 30, {}, hand.aligner));
    const Hypothesis& best = hand.ways.best();
    const HandState& state = best.alignment.state;
    const Eigen::Vector3d tip_m = posed_figure(best.appearance, state).tips_m.col(0);
    const Eigen::Vector2d tip_px = film.camera.project(state.T_camera_hand * tip_m);
    EXPECT_LT((tip_px - film.true_tip_px(0)).norm(), 0.1 * hand.candidate.span_px()) << frame;
  }
}

TEST(Hypotheses, LaidAnewWhenTheLightChangesFaceAndOrientationStayAndTheColoursAreLearned) {
  Beginning hand({}, deg(10), 1);  // palm and back look alike; the palm is told
  ASSERT_TRUE(hand.found);
  hand.ways.expect(&hand.candidate, hand.film.camera, 1, {});
  const auto follow = [&] {
    return hand.ways.follow(hand.film.picture().view(), hand.film.camera, 1.0 / 30, {},
                            hand.aligner);
  };
  ASSERT_TRUE(follow());
  const Hypothesis before = hand.ways.best();
  ASSERT_EQ(before.appearance.face, Face::palm);
  ASSERT_GT(before.alignment.log_ratio, BeliefConfig{}.seen());

  hand.film.extra = [](test::Picture& picture) {  // a dim and bluish lamp
    for (int y = 0; y < 480; ++y)
      for (int x = 0; x < 640; ++x) {
        std::uint8_t* bgr = picture.at(x, y);
        bgr[0] = static_cast<std::uint8_t>(0.6 * bgr[0]);
        bgr[1] = static_cast<std::uint8_t>(0.35 * bgr[1]);
        bgr[2] = static_cast<std::uint8_t>(0.3 * bgr[2]);
      }
  };
  Hypotheses lost = hand.ways;
  EXPECT_TRUE(!follow() || hand.ways.best().alignment.log_ratio < BeliefConfig{}.seen())
      << "it is not followed by colours that are gone";

  ASSERT_TRUE(lost.lay_anew(hand.film.picture().view(), hand.film.camera, {}, hand.aligner));
  const Hypothesis& anew = lost.best();
  EXPECT_GT(anew.alignment.log_ratio, 0.7 * before.alignment.log_ratio);
  EXPECT_EQ(anew.appearance.face, Face::palm);
  EXPECT_LT(test::rotation_error_rad(anew.alignment.state.T_camera_hand,
                                     before.alignment.state.T_camera_hand),
            deg(3));
  hand.ways = lost;
  ASSERT_TRUE(follow());
  EXPECT_GT(hand.ways.best().alignment.log_ratio, 0.7 * before.alignment.log_ratio)
      << "the colours that it learned are this light's";
}

TEST(Hypotheses, AHandThatTurnsToItsEdgeIsFollowedThroughItAndBack) {
  for (const bool through : {true, false}) {
    Beginning hand({}, 0, 6);
    ASSERT_TRUE(hand.found);
    const Eigen::Isometry3d T_front = hand.film.T_camera_hand;
    const int edge = 15, end = 24;
    for (int frame = 1; frame <= end; ++frame) {
      const int turned = through || frame < edge ? frame : 2 * edge - frame;
      hand.film.T_camera_hand =
          T_front * Eigen::AngleAxisd(deg(5.9 * turned), Eigen::Vector3d::UnitY());
      ASSERT_TRUE(hand.ways.follow(hand.film.picture().view(), hand.film.camera, 1.0 / 30, {},
                                   hand.aligner))
          << frame;
    }
    const Hypothesis& best = hand.ways.best();
    Eigen::Isometry3d T = hand.film.T_camera_hand;
    if (through) T.linear() *= Eigen::Vector3d(-1, 1, -1).asDiagonal();  // as its back shows it
    EXPECT_EQ(best.appearance.face, through ? Face::back : Face::palm);
    EXPECT_EQ(best.appearance.layout, through ? Layout::thumb_left : Layout::thumb_right);
    EXPECT_LT(test::rotation_error_rad(best.alignment.state.T_camera_hand, T), deg(6)) << through;
  }
}

TEST(SeenFingers, GoAlongWithTheHandAndAreTheLessSureTheFartherItMoves) {
  test::Film film;
  film.T_camera_hand = film.pose_at(0);
  HandState state = film.hand.state;
  state.T_camera_hand = film.T_camera_hand;
  RoughFingers seen;
  for (int f = 0; f < kFingerCount; ++f) {
    seen.tips_px[f] = film.true_tip_px(f) + Eigen::Vector2d(2 * f, -f);
    seen.roots_px[f] = film.true_root_px(f);
  }
  const SeenFingers fingers = on_hand(seen, film.hand.appearance, state, film.camera);
  const auto then = fingers.in_frame(film.T_camera_hand, film.camera);
  ASSERT_TRUE(then);
  EXPECT_NEAR(then->sigma_px, seen.sigma_px, 1e-9);

  const Eigen::Isometry3d T_then = film.T_camera_hand;
  film.T_camera_hand = film.pose_at(0.5);
  const auto now = fingers.in_frame(film.T_camera_hand, film.camera);
  ASSERT_TRUE(now);
  EXPECT_GT(now->sigma_px, 1.5 * seen.sigma_px);
  for (int f = 0; f < kFingerCount; ++f) {
    EXPECT_LT((then->tips_px[f] - seen.tips_px[f]).norm(), 1e-9);
    EXPECT_LT((now->roots_px[f] - film.true_root_px(f)).norm(), 1e-9);
  }
  Eigen::Isometry3d T_behind = T_then;
  T_behind.translation().z() *= -1;
  EXPECT_FALSE(fingers.in_frame(T_behind, film.camera));
}

TEST(Hypotheses, TheSideThatIsToldLeavesOneFace) {
  for (const Side side : {Side::left, Side::right}) {
    Config config;
    config.side = side;
    const Beginning hand(config, deg(10));
    ASSERT_TRUE(hand.found);
    const Appearance seen = hand.ways.best().appearance;
    EXPECT_EQ(side_of(seen.face, seen.layout), side);
  }
}

}  // namespace
}  // namespace handyar
