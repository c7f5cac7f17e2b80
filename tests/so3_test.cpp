// SPDX-License-Identifier: MIT
#include "pose/so3.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace handyar {
namespace {

using Eigen::Vector3d;

TEST(So3, BetweenIsTheLeastRotationThatTurnsOneDirectionIntoTheOther) {
  const Vector3d from(0.3, -0.2, 0.9), axis = from.unitOrthogonal();
  for (const double angle : {0.0, 1e-9, 1e-4, 0.7, 2.0, 3.1, std::numbers::pi - 1e-6}) {
    const Vector3d to = 5 * (so3::exp(angle * axis) * from);
    const Eigen::Quaterniond q = so3::between(from, to);
    EXPECT_LT((q * from.normalized() - to.normalized()).norm(), 1e-9) << angle;
    EXPECT_NEAR(so3::log(q).norm(), angle, 1e-9) << angle;
  }
}

TEST(So3, BetweenTurnsOppositeDirectionsByHalfATurn) {
  for (const Vector3d& from : {Vector3d(0, 0, 1), Vector3d(1, 0, 0), Vector3d(0.3, -0.2, 0.9)}) {
    const Eigen::Quaterniond q = so3::between(from, -2 * from);
    EXPECT_LT((q * from + from).norm(), 1e-7);
    EXPECT_NEAR(q.norm(), 1, 1e-12);
  }
}

TEST(So3, LogUndoesExp) {
  for (const double angle : {0.0, 1e-8, 0.5, 3.0}) {
    const Vector3d w = angle * Vector3d(2, -1, 3).normalized();
    EXPECT_LT((so3::log(so3::exp(w)) - w).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace handyar
