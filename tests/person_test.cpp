// SPDX-License-Identifier: MIT
#include "track/person.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "track/hand_prior.hpp"

namespace handyar::test {
namespace {

/// A frame in which a finger's turn and the first coefficient of the figure are seen as their sum.
Alignment aligned(double turn_foretold_rad, double turn_sigma_rad, double sum_seen,
                  double sum_sigma) {
  Alignment a;
  a.valid = true;
  a.prior.mean.posture.abduction_rad[1] = turn_foretold_rad;
  a.prior.information(kAbductionAt + 1, kAbductionAt + 1) = 1 / (turn_sigma_rad * turn_sigma_rad);
  HandVector sum = HandVector::Zero();
  sum[kAbductionAt + 1] = sum[kFigureAt] = 1;
  const double precision = 1 / (sum_sigma * sum_sigma);
  a.information = a.prior.information + precision * sum * sum.transpose();
  a.state = a.prior.mean;
  a.state.correct(a.information.llt().solve(precision * (sum_seen - turn_foretold_rad) * sum));
  return a;
}

TEST(Person, WhatWasForetoldOfThePostureIsNoEvidenceOfTheFigure) {
  constexpr double kTurn_rad = 0.3, kRest_rad = 0.5, kSum = 0.8, kSum_sigma = 0.1;
  HandPrior rest;
  rest.information(kAbductionAt + 1, kAbductionAt + 1) = 1 / (kRest_rad * kRest_rad);
  for (const double foretold_sigma_rad : {0.01, 0.1, 0.5}) {
    const Alignment frame = aligned(kTurn_rad, foretold_sigma_rad, kSum, kSum_sigma);
    Person person;
    person.learn(frame, rest, 1);
    // The sum is the coefficient and a turn about rest, whatever was foretold of it.
    const double known = 1 / (kSum_sigma * kSum_sigma + kRest_rad * kRest_rad);
    EXPECT_NEAR(person.information()(0, 0), 1 + known, 1e-9) << foretold_sigma_rad;
    EXPECT_NEAR(person.mean()[0], known * kSum / (1 + known), 1e-9) << foretold_sigma_rad;
    EXPECT_NEAR(person.information()(1, 1), 1, 1e-9) << "of the others nothing was seen";
  }
}

TEST(Person, LearnsAShareOfAFrame) {
  constexpr double kRest_rad = 0.5, kSum = 0.8, kSum_sigma = 0.1;
  HandPrior rest;
  rest.information(kAbductionAt + 1, kAbductionAt + 1) = 1 / (kRest_rad * kRest_rad);
  const Alignment frame = aligned(0, kRest_rad, kSum, kSum_sigma);
  Person person;
  person.learn(frame, rest, 0.25);
  const double known = 0.25 / (kSum_sigma * kSum_sigma + kRest_rad * kRest_rad);
  EXPECT_NEAR(person.information()(0, 0), 1 + known, 1e-9);
  EXPECT_NEAR(person.estimate().covariance(0, 0), 1 / (1 + known), 1e-9);
}

TEST(Person, LearnsHowTheFingersAreHeldUnlessTheyWereMeasured) {
  Alignment frame = aligned(0, 0.5, 0, 1);
  frame.state.posture.flexion_rad[0] = 0.2;
  frame.state.posture.abduction_rad[4] = -0.1;
  HandModel measured = average_adult_hand();
  measured.source = HandSource::checkerboard;
  Person stranger(average_adult_hand()), known(measured);
  for (int i = 0; i < 12; ++i)
    for (Person* person : {&stranger, &known}) person->learn(frame, {}, 0.25);
  EXPECT_NEAR(stranger.rest().flexion_rad[0], 0.2 * 3 / 4, 1e-9);  // of four views one is anybody's
  EXPECT_NEAR(stranger.rest().abduction_rad[4], -0.1 * 3 / 4, 1e-9);
  EXPECT_EQ(known.rest().flexion_rad[0], 0);
  const HandPrior later = prior_around({}, stranger, kLongAgo_s, {});
  EXPECT_NEAR(later.mean.posture.flexion_rad[0], 0.2 * 3 / 4, 1e-9);
}

/// After a second in which every finger but the thumb is turned and bent by `angle_rad`.
double liveliness_of(double angle_rad, double before, int frames_per_s) {
  Posture posture;
  for (int f = 1; f < kFingerCount; ++f)
    posture.abduction_rad[f] = posture.flexion_rad[f] = f % 2 == 0 ? angle_rad : -angle_rad;
  double liveliness = before;
  for (int i = 0; i < frames_per_s; ++i)
    liveliness =
        liveliness_after(1.0 / frames_per_s, posture, {}, liveliness, BeliefConfig{}.same_s);
  return liveliness;
}

TEST(Liveliness, FallsWhereFingersAreAtRestAndComesBackWhereTheyMove) {
  const double still = liveliness_of(0.008, 1, 30);
  EXPECT_GT(still, 0);
  EXPECT_LT(still, 0.3);
  const double moving = liveliness_of(0.04, still, 30);
  EXPECT_GT(moving, 0.8);
  EXPECT_LE(liveliness_of(1.0, still, 30), 1);
}

TEST(Liveliness, IsOfWhatStraysFromThePersonsOwnRest) {
  Posture thumb_out;
  thumb_out.flexion_rad[0] = 0.4;
  const double same_s = BeliefConfig{}.same_s;
  EXPECT_EQ(liveliness_after(0.03, thumb_out, {}, kStillest, same_s), 1);
  EXPECT_EQ(liveliness_after(0.03, thumb_out, thumb_out, kStillest, same_s), kStillest);
}

TEST(Liveliness, IsTheSameAtEveryFrameRate) {
  EXPECT_NEAR(liveliness_of(0.03, 1, 15), liveliness_of(0.03, 1, 120), 1e-9);
}

TEST(Liveliness, FingersThatAreAtRestAreHeldSoMuchFirmer) {
  const Person person(average_adult_hand());
  const HandPrior lively = prior_around({}, person, kLongAgo_s, {}),
                  still = prior_around({}, person, kLongAgo_s, {}, 0.5);
  EXPECT_NEAR(still.information(kFlexionAt + 2, kFlexionAt + 2),
              4 * lively.information(kFlexionAt + 2, kFlexionAt + 2), 1e-6);
  EXPECT_EQ(still.information(0, 0), lively.information(0, 0));
}

}  // namespace
}  // namespace handyar::test
