// SPDX-License-Identifier: MIT
#include "track/person.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

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

}  // namespace
}  // namespace handyar::test
