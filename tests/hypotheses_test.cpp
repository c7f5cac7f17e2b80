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
    film.T_camera_hand = film.pose_at(0);
    candidate.layout = film.hand.appearance.layout;
    candidate.palm_log_odds = palm_log_odds;
    for (int f = 0; f < kFingerCount; ++f) {
      candidate.tips_px[f] = film.true_tip_px(f).cast<float>();
      candidate.roots_px[f] = film.true_root_px(f).cast<float>();
    }
    found = ways.begin(candidate, film.picture().view(), film.camera,
                       Person(estimate_figure(average_adult_hand())), config, aligner);
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
    const Matrix6d spread = hand.ways.spread();
    EXPECT_GT(std::sqrt(spread.topLeftCorner<3, 3>().trace()), deg(1));
    EXPECT_GE(Eigen::SelfAdjointEigenSolver<Matrix6d>(spread).eigenvalues().minCoeff(), -1e-12);
    hand.ways.resume(hand.ways.best());
    EXPECT_LT(hand.ways.spread().norm(), 1e-20) << "one way is not in doubt";
  }
}

TEST(Hypotheses, TheFinderTellsPalmFromBackWhereTheOutlineDoesNot) {
  for (const float palm_log_odds : {-6.0f, 6.0f}) {
    const Beginning hand({}, 0, palm_log_odds);
    ASSERT_TRUE(hand.found);
    EXPECT_EQ(hand.ways.best().appearance.face, palm_log_odds > 0 ? Face::palm : Face::back);
  }
}

TEST(Hypotheses, TheFinderChangesItsMindAboutTheFace) {
  Beginning hand({}, 0, 1);
  ASSERT_TRUE(hand.found);
  HandCandidate back = hand.candidate;
  back.palm_log_odds = -6;
  hand.ways.expect(&back, 1, {});
  ASSERT_TRUE(
      hand.ways.follow(hand.film.picture().view(), hand.film.camera, 1.0 / 30, {}, hand.aligner));
  EXPECT_EQ(hand.ways.best().appearance.face, Face::back);
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
