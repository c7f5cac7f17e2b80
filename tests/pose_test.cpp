// SPDX-License-Identifier: MIT
#include "handyar/pose.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "../src/pose_refinement.hpp"
#include "handyar/hand_shape.hpp"
#include "handyar/planar_pose.hpp"
#include "synthetic_hand.hpp"

namespace handyar {
namespace {

using test::deg;
using test::hand_at;
using test::rendered_camera;
using test::rendered_hand;

HandModel without_valleys(HandModel hand) {
  hand.has_valleys = hand.has_axes = false;
  return hand;
}

Camera distorted_camera() {
  Camera c = rendered_camera();
  c.distortion = {-0.21, 0.09, 0.0012, -0.0007, -0.01};
  return c;
}

PoseConfig tips_config() {
  PoseConfig c;
  c.method = PoseMethod::tips;
  return c;
}

/// In what the method takes a finger to end.
double tip_radius_m(PoseMethod method) { return method == PoseMethod::tips ? 0.0 : kTipRadius_m; }

/// Turns each finger about a knuckle 100 mm behind its tip, towards the thumb (at +x).
HandModel with_spread(HandModel hand, const std::array<double, kFingerCount>& towards_thumb_rad) {
  const std::array<Eigen::Vector2d, kFingerCount> knuckles_m{
      {{0.019, -0.067}, {0.019, -0.003}, {-0.001, -0.006}, {-0.021, -0.009}, {-0.041, -0.012}}};
  for (int i = 0; i < kFingerCount; ++i) {
    for (auto* const points_m : {&hand.tips_m, &hand.axis_ends_m, &hand.axis_roots_m}) {
      const Eigen::Vector2d arm_m = points_m->col(i).head<2>() - knuckles_m[i];
      points_m->col(i).head<2>() =
          knuckles_m[i] + Eigen::Rotation2Dd(-towards_thumb_rad[i]) * arm_m;
    }
  }
  return hand;
}

TEST(PlanarPose, FindsTheExactPoseAmongItsTwo) {
  std::array<Eigen::Vector2d, 5> plane, image;
  const Camera camera = rendered_camera();
  for (double tilt : {0.0, 5.0, 20.0, 45.0, 70.0})
    for (double axis = 0; axis < 360; axis += 40) {
      const Eigen::Isometry3d truth = hand_at(0.45, deg(tilt), deg(axis), {0.05, 0.02});
      for (int i = 0; i < 5; ++i) {
        plane[i] = rendered_hand().tips_m.col(i).head<2>();
        const Eigen::Vector3d p(plane[i].x(), plane[i].y(), 0);
        image[i] = camera.unproject(camera.project(truth * p));
      }
      const auto poses = solve_planar(plane, image);
      ASSERT_TRUE(poses) << tilt << ' ' << axis;
      const Eigen::Isometry3d& T = (*poses)[0].T_camera_plane;
      EXPECT_LT(test::rotation_error_rad(T, truth), 1e-6) << tilt << ' ' << axis;
      EXPECT_LT(test::translation_error_m(T, truth), 1e-7) << tilt << ' ' << axis;
      EXPECT_LT((*poses)[0].rms, 1e-9);
      EXPECT_GE((*poses)[1].rms, (*poses)[0].rms);
    }
}

TEST(PlanarPose, TheOtherSolutionIsTheMirroredTilt) {
  std::array<Eigen::Vector2d, 5> plane, image;
  const Eigen::Isometry3d truth = hand_at(0.9, deg(20), deg(30));
  for (int i = 0; i < 5; ++i) {
    plane[i] = rendered_hand().tips_m.col(i).head<2>();
    image[i] = (truth * Eigen::Vector3d(plane[i].x(), plane[i].y(), 0)).hnormalized();
  }
  const auto poses = solve_planar(plane, image);
  ASSERT_TRUE(poses);
  const double apart =
      test::rotation_error_rad((*poses)[0].T_camera_plane, (*poses)[1].T_camera_plane);
  EXPECT_NEAR(apart, deg(40), deg(4));
}

TEST(PlanarPose, RefusesWhatDoesNotDetermineAPlane) {
  const std::array<Eigen::Vector2d, 4> square{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
  const std::array<Eigen::Vector2d, 4> line{{{0, 0}, {1, 1}, {2, 2}, {3, 3}}};
  const std::array<Eigen::Vector2d, 4> three_on_a_line{{{0, 0}, {1, 0}, {2, 0}, {0, 1}}};
  std::array<Eigen::Vector2d, 4> nan = square;
  nan[2].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(solve_planar(square, square));
  EXPECT_FALSE(solve_planar(std::span(square).first(3), std::span(square).first(3)));
  EXPECT_FALSE(solve_planar(square, std::span(square).first(3)));
  EXPECT_FALSE(solve_planar(line, square));
  EXPECT_FALSE(solve_planar(square, line));
  EXPECT_FALSE(solve_planar(three_on_a_line, three_on_a_line));
  EXPECT_FALSE(solve_planar(nan, square));
  EXPECT_FALSE(solve_planar(square, nan));
}

TEST(Reprojection, JacobiansAgreeWithCentralDifferences) {
  const Camera camera = distorted_camera();
  const Eigen::Isometry3d T = hand_at(0.45, deg(35), deg(50));
  PosePoint point;
  point.hand_m << 0.09, 0.05, 0.004;
  point.px << 300, 200;
  Eigen::Vector2d r, plus, minus;
  Eigen::Matrix<double, 2, 6> J_pose, unused_pose;
  Eigen::Matrix<double, 2, 3> J_hand, unused_hand;
  ASSERT_TRUE(reprojection(point, camera, T, r, J_pose, J_hand));
  const double h = 1e-6;
  const auto moved = [&](int i, double by) {  // rotation on the left, as the covariance has it
    Eigen::Isometry3d M = T;
    if (i < 3)
      M.linear() = Eigen::AngleAxisd(by, Eigen::Vector3d::Unit(i)) * T.linear();
    else
      M.translation()[i - 3] += by;
    return M;
  };
  for (int i = 0; i < 6; ++i) {
    ASSERT_TRUE(reprojection(point, camera, moved(i, h), plus, unused_pose, unused_hand));
    ASSERT_TRUE(reprojection(point, camera, moved(i, -h), minus, unused_pose, unused_hand));
    const Eigen::Vector2d numeric =
        (minus - plus) / (2 * h);  // of the projection, not the residual
    EXPECT_LT((J_pose.col(i) - numeric).norm(), 1e-5 * J_pose.col(i).norm() + 1e-4) << i;
  }
  for (int i = 0; i < 3; ++i) {
    PosePoint a = point, b = point;
    a.hand_m[i] += h;
    b.hand_m[i] -= h;
    ASSERT_TRUE(reprojection(a, camera, T, plus, unused_pose, unused_hand));
    ASSERT_TRUE(reprojection(b, camera, T, minus, unused_pose, unused_hand));
    EXPECT_LT((J_hand.col(i) - (minus - plus) / (2 * h)).norm(),
              1e-5 * J_hand.col(i).norm() + 1e-4);
  }
}

TEST(Reprojection, ARoundEndsJacobianAgreesWithCentralDifferences) {
  const Camera camera = rendered_camera();
  PosePoint point;
  point.hand_m << 0.0, 0.085, 0.002;
  point.direction << 0, 1, 0;
  point.radius_m = 0.005;
  point.px << 300, 200;
  for (double axis : {0.0, 50.0, 140.0, 230.0}) {
    const Eigen::Isometry3d T = hand_at(0.45, deg(40), deg(axis));
    Eigen::Vector2d r, plus, minus;
    Eigen::Matrix<double, 2, 6> J_pose, unused_pose;
    Eigen::Matrix<double, 2, 3> unused_hand;
    ASSERT_TRUE(reprojection(point, camera, T, r, J_pose, unused_hand));
    const double h = 1e-6;
    for (int i = 0; i < 3; ++i) {
      Eigen::Isometry3d a = T, b = T;
      a.linear() = Eigen::AngleAxisd(h, Eigen::Vector3d::Unit(i)) * T.linear();
      b.linear() = Eigen::AngleAxisd(-h, Eigen::Vector3d::Unit(i)) * T.linear();
      ASSERT_TRUE(reprojection(point, camera, a, plus, unused_pose, unused_hand));
      ASSERT_TRUE(reprojection(point, camera, b, minus, unused_pose, unused_hand));
      // But for the small turn of the line of sight, which is left out.
      EXPECT_LT((J_pose.col(i) - (minus - plus) / (2 * h)).norm(), 2.0) << axis << ' ' << i;
      point.radius_m = 0;
      Eigen::Matrix<double, 2, 6> J_sharp;
      ASSERT_TRUE(reprojection(point, camera, T, r, J_sharp, unused_hand));
      point.radius_m = 0.005;
      if (axis == 0 && i == 0) {
        EXPECT_GT((J_sharp - J_pose).col(i).norm(), 4.0);
      }
    }
  }
}

TEST(OffsetOfLine, JacobiansAgreeWithCentralDifferences) {
  const Camera camera = distorted_camera();
  PoseLine line;
  line.hand_m = {Eigen::Vector3d(0.04, 0.06, 0.001), Eigen::Vector3d(0.03, 0.02, 0.005)};
  line.per_spread_m = {Eigen::Vector3d(0.06, -0.02, 0), Eigen::Vector3d(0.02, -0.01, 0)};
  const Eigen::Isometry3d T = hand_at(0.45, deg(35), deg(50));
  // A place between the points and one beyond them, both beside the line.
  for (int k = 0; k < 2; ++k)
    line.px[k] = camera.project(T * (line.hand_m[0] + Eigen::Vector3d(0.004, k * 0.01, 0)));
  Eigen::Vector2d r, plus, minus, J_spread, unused_spread;
  Eigen::Matrix<double, 2, 6> J_pose, unused_pose;
  Eigen::Matrix2d S;
  const double spread = 0.03, h = 1e-6;
  ASSERT_TRUE(offset_of_line(line, camera, T, spread, r, J_pose, J_spread, S));
  EXPECT_GT(r.cwiseAbs().minCoeff(), 1);
  for (int i = 0; i < 6; ++i) {
    Eigen::Isometry3d a = T, b = T;
    if (i < 3) {
      a.linear() = Eigen::AngleAxisd(h, Eigen::Vector3d::Unit(i)) * T.linear();
      b.linear() = Eigen::AngleAxisd(-h, Eigen::Vector3d::Unit(i)) * T.linear();
    } else {
      a.translation()[i - 3] += h;
      b.translation()[i - 3] -= h;
    }
    ASSERT_TRUE(offset_of_line(line, camera, a, spread, plus, unused_pose, unused_spread, S));
    ASSERT_TRUE(offset_of_line(line, camera, b, spread, minus, unused_pose, unused_spread, S));
    EXPECT_LT((J_pose.col(i) - (minus - plus) / (2 * h)).norm(), 1e-4 * J_pose.norm()) << i;
  }
  ASSERT_TRUE(offset_of_line(line, camera, T, spread + h, plus, unused_pose, unused_spread, S));
  ASSERT_TRUE(offset_of_line(line, camera, T, spread - h, minus, unused_pose, unused_spread, S));
  EXPECT_LT((J_spread - (minus - plus) / (2 * h)).norm(), 1e-4 * J_spread.norm());
}

TEST(OffsetOfLine, AFingerThatPointsAtTheEyeTellsNothing) {
  PoseLine line;
  const Eigen::Isometry3d T = hand_at(0.45, 0, 0);
  const Eigen::Vector3d towards_eye = (T.inverse().translation() - line.hand_m[0]).normalized();
  line.hand_m = {Eigen::Vector3d(0, 0.03, 0), Eigen::Vector3d(0, 0.03, 0)};
  line.hand_m[1] += 0.02 * (T.inverse().translation() - line.hand_m[0]).normalized();
  line.per_spread_m = {towards_eye, towards_eye};
  line.px = {Eigen::Vector2d(300, 200), Eigen::Vector2d(310, 260)};
  Eigen::Vector2d r, J_spread;
  Eigen::Matrix<double, 2, 6> J_pose;
  Eigen::Matrix2d S;
  ASSERT_TRUE(offset_of_line(line, rendered_camera(), T, 0, r, J_pose, J_spread, S));
  EXPECT_TRUE(r.isZero() && J_pose.isZero() && J_spread.isZero());
  EXPECT_GT(S.determinant(), 0);
}

// Bent away from the camera a finger shows its round end, which does not get shorter.
TEST(RoundTips, TheEndOfTheOutlineLeavesTheTipOfAFingerSeenObliquely) {
  const Eigen::Vector3d tip_m(0, 0.085, 0), direction(0, 1, 0);
  EXPECT_LT((outline_end_m(tip_m, direction, 0.004, {0, 0.081, 0.4}) - tip_m).norm(), 1e-9);
  const Eigen::Vector3d centre_m(0, 0.081, 0), eye_m = centre_m + Eigen::Vector3d(0, -0.3, 0.3);
  const Eigen::Vector3d end_m = outline_end_m(tip_m, direction, 0.004, eye_m);
  EXPECT_NEAR((end_m - centre_m).norm(), 0.004, 1e-9);
  EXPECT_NEAR((end_m - centre_m).dot(eye_m - centre_m), 0, 1e-9);
  EXPECT_GT(end_m.z(), 0.002) << "the end that is seen lies on the upper side";
}

struct Case {
  PoseMethod method;
  bool valleys;
  bool distortion;
  Layout layout;
};

class ExactPose : public testing::TestWithParam<Case> {};

TEST_P(ExactPose, IsRecoveredWithoutNoise) {
  const Case c = GetParam();
  HandModel hand = rendered_hand().for_layout(c.layout);
  hand.has_valleys = c.valleys;
  const Camera camera = c.distortion ? distorted_camera() : rendered_camera();
  PoseConfig config;
  config.method = c.method;
  for (double tilt : {10.0, 30.0, 60.0})
    for (double axis = 0; axis < 360; axis += 45)
      for (double distance_m : {0.25, 0.45, 0.9}) {
        const Eigen::Isometry3d truth = hand_at(distance_m, deg(tilt), deg(axis));
        const HandObservation seen = test::project(hand, camera, truth, tip_radius_m(c.method));
        const auto pose = estimate_pose(seen, hand, camera, config);
        ASSERT_TRUE(pose) << tilt << ' ' << axis << ' ' << distance_m;
        EXPECT_LT(test::rotation_error_rad(pose->T_camera_hand, truth), 1e-6)
            << tilt << ' ' << axis << ' ' << distance_m;
        EXPECT_LT(test::translation_error_m(pose->T_camera_hand, truth), 1e-6);
        EXPECT_LT(pose->rms_px, 1e-4);
        EXPECT_LT(pose->ambiguity, 0.01);
        EXPECT_EQ(pose->points_used, c.method != PoseMethod::tips && c.valleys ? 9 : 5);
        EXPECT_EQ(pose->axes_used, c.method == PoseMethod::outline ? kFingerCount : 0);
        for (double spread : pose->spread_rad) EXPECT_NEAR(spread, 0.0, 1e-5);
        EXPECT_TRUE(pose->covariance.ldlt().isPositive());
      }
}

INSTANTIATE_TEST_SUITE_P(
    Methods, ExactPose,
    testing::Values(Case{PoseMethod::tips, false, false, Layout::thumb_right},
                    Case{PoseMethod::tips, false, true, Layout::thumb_left},
                    Case{PoseMethod::points, false, true, Layout::thumb_right},
                    Case{PoseMethod::points, true, false, Layout::thumb_left},
                    Case{PoseMethod::outline, true, true, Layout::thumb_left},
                    Case{PoseMethod::outline, true, false, Layout::thumb_right},
                    Case{PoseMethod::points, true, true, Layout::thumb_right}));

TEST(Pose, FourOfFiveTipsAreEnough) {
  const HandModel hand = without_valleys(rendered_hand());
  const Eigen::Isometry3d truth = hand_at(0.45, deg(35), deg(70));
  for (int missing = 0; missing < kFingerCount; ++missing)
    for (PoseMethod method : {PoseMethod::tips, PoseMethod::points}) {
      PoseConfig config;
      config.method = method;
      HandObservation seen = test::project(hand, rendered_camera(), truth, tip_radius_m(method));
      seen.tips[missing].seen = false;
      const auto pose = estimate_pose(seen, hand, rendered_camera(), config);
      ASSERT_TRUE(pose) << missing;
      EXPECT_LT(test::rotation_error_rad(pose->T_camera_hand, truth), 1e-6) << missing;
      EXPECT_EQ(pose->points_used, 4);
    }
}

TEST(Pose, RefusesDegenerateInput) {
  const HandModel hand = rendered_hand(), bare = without_valleys(hand);
  const Camera camera = rendered_camera();
  const HandObservation good = test::project(hand, camera, hand_at(0.45, deg(30), 0));
  ASSERT_TRUE(estimate_pose(good, bare, camera));

  HandObservation three = good;
  three.tips[0].seen = three.tips[4].seen = false;
  EXPECT_FALSE(estimate_pose(three, bare, camera)) << "three tips";
  EXPECT_TRUE(estimate_pose(three, hand, camera)) << "three tips and four valleys";
  EXPECT_FALSE(estimate_pose(three, hand, camera, tips_config()));

  HandObservation nan = good;
  nan.tips[1].px.y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(estimate_pose(nan, bare, camera));
  nan = good;
  nan.tips[1].sigma_px = 0;
  EXPECT_FALSE(estimate_pose(nan, bare, camera));

  HandObservation line = good, one_place = good;
  for (int i = 0; i < kFingerCount; ++i) {
    line.tips[i].px = Eigen::Vector2d(100 + 50 * i, 120 + 30 * i);
    one_place.tips[i].px = Eigen::Vector2d(320, 240);
  }
  EXPECT_FALSE(estimate_pose(line, bare, camera));
  EXPECT_FALSE(estimate_pose(one_place, bare, camera));

  HandModel no_hand = bare;
  no_hand.tips_m.setZero();
  EXPECT_FALSE(estimate_pose(good, no_hand, camera));
  no_hand.tips_m.setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_FALSE(estimate_pose(good, no_hand, camera));
}

TEST(Pose, TheWrongLayoutShowsItsBackAndIsRefused) {
  const HandModel hand = rendered_hand();
  const HandObservation seen =
      test::project(hand, rendered_camera(), hand_at(0.45, deg(30), deg(20)));
  EXPECT_FALSE(estimate_pose(seen, hand.for_layout(Layout::thumb_left), rendered_camera()));
}

TEST(Pose, NeverGivesNaNWhateverIsSeen) {
  auto rng = test::random_for("Pose.NeverGivesNaNWhateverIsSeen");
  std::uniform_real_distribution<double> anywhere(-100, 700);
  const HandModel hand = rendered_hand();
  int poses = 0;
  for (int i = 0; i < 4000; ++i) {
    HandObservation seen;
    for (ObservedPoint& p : seen.tips) p = {{anywhere(rng), anywhere(rng)}, 1.0, true};
    for (ObservedPoint& p : seen.valleys) p = {{anywhere(rng), anywhere(rng)}, 1.0, true};
    const auto pose = estimate_pose(seen, i % 2 ? hand : without_valleys(hand), rendered_camera());
    if (!pose) continue;
    ++poses;
    ASSERT_TRUE(pose->T_camera_hand.matrix().allFinite());
    ASSERT_TRUE(pose->covariance.allFinite());
    ASSERT_NEAR(pose->T_camera_hand.linear().determinant(), 1.0, 1e-9);
    ASSERT_GT(pose->covariance.ldlt().vectorD().minCoeff(), 0.0);
    ASSERT_GT(pose->reduced_chi2, 1.0);
  }
  EXPECT_GT(poses, 50);
}

/// A pose known to be near `T`.
PosePrior expecting(const Eigen::Isometry3d& T, double sigma_rad, double sigma_m) {
  PosePrior prior;
  prior.prediction.emplace();
  prior.prediction->T_camera_hand = T;
  prior.prediction->covariance.diagonal() << Eigen::Vector3d::Constant(sigma_rad * sigma_rad),
      Eigen::Vector3d::Constant(sigma_m * sigma_m);
  return prior;
}

Eigen::Isometry3d disturbed(const Eigen::Isometry3d& T, double sigma_rad, double sigma_m,
                            std::mt19937& rng) {
  Eigen::Isometry3d result = T;
  const Eigen::Vector3d w = test::gauss3(rng, sigma_rad);
  result.linear() = Eigen::AngleAxisd(w.norm(), w.normalized()) * T.linear();
  result.translation() += test::gauss3(rng, sigma_m);
  return result;
}

/// Share of estimates more than 20 degrees off (the mirrored tilt is 30 degrees away) although the
/// other planar solution, the one that truth itself would have chosen, was nearer.
double flipped_share(const HandModel& hand, const PoseConfig& config, bool predicted,
                     std::mt19937& rng) {
  const int n = 1000;
  int flipped = 0;
  std::uniform_real_distribution<double> axis(0, 2 * std::numbers::pi);
  for (int i = 0; i < n; ++i) {
    const Eigen::Isometry3d truth = hand_at(0.45, deg(15), axis(rng));
    HandObservation seen = test::project(rendered_hand(), rendered_camera(), truth);
    test::add_noise(seen, 1.0, rng);
    const PosePrior prior =
        predicted ? expecting(disturbed(truth, deg(3), 0.003, rng), deg(3), 0.003) : PosePrior{};
    const auto pose = estimate_pose(seen, hand, rendered_camera(), config, prior);
    const auto best =
        estimate_pose(seen, hand, rendered_camera(), config, expecting(truth, deg(1), 0.001));
    if (!pose || !best) return 1.0;
    const double error = test::rotation_error_rad(pose->T_camera_hand, truth);
    const double least = test::rotation_error_rad(best->T_camera_hand, truth);
    if (error > deg(20) && error > least + deg(5)) ++flipped;
  }
  return static_cast<double>(flipped) / n;
}

TEST(Ambiguity, FlipsAreRareAndAPredictionEndsThem) {
  auto rng = test::random_for("Ambiguity.FlipsAreRareAndAPredictionEndsThem");
  const HandModel hand = rendered_hand(), bare = without_valleys(hand);
  EXPECT_LT(flipped_share(hand, {}, false, rng), 0.02);
  EXPECT_EQ(flipped_share(hand, {}, true, rng), 0.0);
  EXPECT_LT(flipped_share(bare, tips_config(), false, rng), 0.03);
  // Five rigid tips at 1 px: in 2 of 1000 frames the noise outweighs any prediction this uncertain.
  EXPECT_LE(flipped_share(bare, tips_config(), true, rng), 0.003);
  EXPECT_EQ(flipped_share(bare, {}, true, rng), 0.0);
}

TEST(Ambiguity, TheFrameSaysWhenThePredictionDecidedAgainstIt) {
  auto rng = test::random_for("Ambiguity.TheFrameSays");
  const HandModel hand = rendered_hand();
  int decided = 0;
  double for_right = 0, for_wrong = 0;
  const int n = 50;
  for (int i = 0; i < n; ++i) {
    const Eigen::Isometry3d truth = hand_at(0.45, deg(25), deg(7 * i));
    const Eigen::Isometry3d turned_over = hand_at(0.45, deg(-25), deg(7 * i));
    HandObservation seen = test::project(hand, rendered_camera(), truth);
    test::add_noise(seen, 0.5, rng);
    const auto right =
        estimate_pose(seen, hand, rendered_camera(), {}, expecting(truth, deg(3), 0.003));
    const auto wrong =
        estimate_pose(seen, hand, rendered_camera(), {}, expecting(turned_over, deg(1), 0.003));
    ASSERT_TRUE(right && wrong);
    for_right += right->planar_log_ratio / n;
    if (test::rotation_error_rad(wrong->T_camera_hand, truth) < deg(15)) continue;
    for_wrong += wrong->planar_log_ratio;
    ++decided;
  }
  ASSERT_GT(decided, n / 4);
  EXPECT_GT(for_right, 2);
  EXPECT_LT(for_wrong / decided, -2);
}

TEST(Ambiguity, IsReported) {
  const HandModel hand = rendered_hand();
  auto rng = test::random_for("Ambiguity.IsReported");
  double near_small = 0, far_small = 0;
  for (int i = 0; i < 50; ++i)
    for (double distance_m : {0.3, 1.5}) {
      HandObservation seen =
          test::project(hand, rendered_camera(), hand_at(distance_m, deg(30), deg(7 * i)));
      test::add_noise(seen, 1.0, rng);
      const auto pose = estimate_pose(seen, hand, rendered_camera());
      ASSERT_TRUE(pose);
      (distance_m < 1 ? near_small : far_small) += pose->ambiguity / 50;
    }
  EXPECT_LT(near_small, 0.35);
  EXPECT_GT(far_small, near_small + 0.2);
}

TEST(Spread, IsMeasuredAndTakenOutOfThePose) {
  const HandModel hand = rendered_hand();
  const std::array<double, kFingerCount> turned{deg(4), deg(-3), deg(2), deg(-3), deg(3)};
  const HandModel respread = with_spread(hand, turned);
  for (Layout layout : {Layout::thumb_right, Layout::thumb_left}) {
    const Eigen::Isometry3d truth = hand_at(0.45, deg(30), deg(60));
    const HandObservation seen =
        test::project(respread.for_layout(layout), rendered_camera(), truth);
    const auto rigid =
        estimate_pose(seen, hand.for_layout(layout), rendered_camera(), tips_config());
    const auto pose = estimate_pose(seen, hand.for_layout(layout), rendered_camera());
    ASSERT_TRUE(rigid && pose);
    for (int i = 0; i < kFingerCount; ++i)
      EXPECT_NEAR(pose->spread_rad[i], turned[i], deg(2.0)) << kFingerNames[i];
    EXPECT_LT(test::rotation_error_rad(pose->T_camera_hand, truth), deg(4.0));
    EXPECT_LT(test::translation_error_m(pose->T_camera_hand, truth), 0.010);
    EXPECT_LT(test::rotation_error_rad(pose->T_camera_hand, truth),
              0.5 * test::rotation_error_rad(rigid->T_camera_hand, truth));
    for (double spread : rigid->spread_rad) EXPECT_EQ(spread, 0.0);
  }
}

/// Median errors of hands that were calibrated to a millimetre and whose fingers have turned by
/// `sigma_rad` since, each by itself.
struct Errors {
  double rotation_rad = 0, translation_m = 0;
};
Errors errors_of_respread_hands(PoseMethod method, double sigma_rad) {
  auto rng = test::random_for("errors_of_respread_hands");
  const HandModel hand = rendered_hand();
  PoseConfig config;
  config.method = method;
  std::uniform_real_distribution<double> axis(0, 2 * std::numbers::pi);
  std::vector<double> rotation_rad, translation_m;
  for (int i = 0; i < 300; ++i) {
    std::array<double, kFingerCount> turned;
    for (double& t : turned) t = test::gauss(rng, sigma_rad);
    const Eigen::Isometry3d truth = hand_at(0.45, deg(40), axis(rng));
    HandModel actual = with_spread(hand, turned);
    for (auto* const points_m : {&actual.tips_m, &actual.axis_ends_m, &actual.axis_roots_m})
      for (int k = 0; k < kFingerCount; ++k) points_m->col(k) += test::gauss3(rng, 0.001);
    for (int k = 0; k < kValleyCount; ++k) actual.valleys_m.col(k) += test::gauss3(rng, 0.001);
    HandObservation seen = test::project(actual, rendered_camera(), truth);
    test::add_noise(seen, 0.5, rng);
    const auto pose =
        estimate_pose(seen, hand, rendered_camera(), config, expecting(truth, deg(10), 0.03));
    if (!pose) continue;
    rotation_rad.push_back(test::rotation_error_rad(pose->T_camera_hand, truth));
    translation_m.push_back(test::translation_error_m(pose->T_camera_hand, truth));
  }
  const auto median = [](std::vector<double>& v) {
    std::nth_element(v.begin(), v.begin() + std::ptrdiff_t(v.size() / 2), v.end());
    return v[v.size() / 2];
  };
  return {median(rotation_rad), median(translation_m)};
}

TEST(Spread, TheFingersSidesTellItFromAMoveOfTheHand) {
  const Errors as_calibrated = errors_of_respread_hands(PoseMethod::outline, 0);
  const Errors respread = errors_of_respread_hands(PoseMethod::outline, deg(2));
  const Errors without_sides = errors_of_respread_hands(PoseMethod::points, deg(2));
  for (const auto& [name, e] : {std::pair{"as_calibrated", as_calibrated},
                                {"respread", respread},
                                {"without_sides", without_sides}})
    RecordProperty(name, std::to_string(e.rotation_rad * 180 / std::numbers::pi) + " degrees, " +
                             std::to_string(1000 * e.translation_m) + " mm");
  EXPECT_LT(respread.rotation_rad, 1.5 * as_calibrated.rotation_rad);
  EXPECT_LT(respread.translation_m, 1.5 * as_calibrated.translation_m);
  EXPECT_LT(respread.rotation_rad, 0.9 * without_sides.rotation_rad);
  EXPECT_LT(respread.translation_m, 0.75 * without_sides.translation_m);
}

TEST(Spread, WithoutValleysTheHandIsTakenAsRigid) {
  const HandModel hand = rendered_hand();
  const HandObservation seen =
      test::project(hand, rendered_camera(), hand_at(0.45, deg(30), deg(60)));
  const auto with = estimate_pose(seen, hand, rendered_camera());
  const auto without = estimate_pose(seen, without_valleys(hand), rendered_camera());
  const auto rigid = estimate_pose(seen, without_valleys(hand), rendered_camera(), tips_config());
  ASSERT_TRUE(with && without && rigid);
  for (double spread : without->spread_rad) EXPECT_EQ(spread, 0.0);
  EXPECT_EQ(rigid->points_used, kFingerCount);
  EXPECT_EQ(without->points_used, kFingerCount + kValleyCount);
  EXPECT_EQ(with->points_used, kFingerCount + kValleyCount);
}

TEST(AverageValleys, FollowTheTipsAndTheirLayout) {
  const HandModel hand = rendered_hand();
  const auto valleys_m = average_valleys_m(hand);
  for (int k = 0; k < kValleyCount; ++k)
    EXPECT_LT((valleys_m.col(k) - hand.valleys_m.col(k)).head<2>().norm(), 0.006) << k;
  auto mirrored_m = average_valleys_m(hand.for_layout(Layout::thumb_left));
  mirrored_m.row(0) *= -1;
  EXPECT_TRUE(mirrored_m.isApprox(valleys_m, 1e-9));
  HandModel larger = hand;
  larger.tips_m *= 1.2;
  EXPECT_TRUE(average_valleys_m(larger).isApprox(1.2 * valleys_m, 1e-9));
}

TEST(AverageValleys, HoldThePoseWhereATipIsMisread) {
  // Fingertips alone take a thumb that is read some millimetres off for a hand that tilts.
  const HandModel hand = rendered_hand();
  double by_tips_rad = 0, by_all_rad = 0, in_doubt_rad = 0;
  for (const double axis : {0.0, 60.0, 120.0, 180.0, 240.0, 300.0})
    for (const Eigen::Vector2d& misread_px :
         {Eigen::Vector2d(-10, 0), {0, 10}, {10, 0}, {0, -10}}) {
      const Eigen::Isometry3d truth = hand_at(0.45, deg(20), deg(axis));
      HandObservation seen = test::project(hand, rendered_camera(), truth);
      seen.tips[0].px += misread_px;
      const PosePrior prior = expecting(truth, deg(10), 0.03);
      const auto tips =
          estimate_pose(seen, without_valleys(hand), rendered_camera(), tips_config(), prior);
      const auto all = estimate_pose(seen, without_valleys(hand), rendered_camera(), {}, prior);
      ASSERT_TRUE(tips && all);
      by_tips_rad += test::rotation_error_rad(tips->T_camera_hand, truth) / 24;
      by_all_rad += test::rotation_error_rad(all->T_camera_hand, truth) / 24;
      seen.tips[0].sigma_px = 10;
      const auto in_doubt =
          estimate_pose(seen, without_valleys(hand), rendered_camera(), {}, prior);
      ASSERT_TRUE(in_doubt);
      EXPECT_LT(in_doubt->rms_px, all->rms_px) << "which says less of the fit";
      in_doubt_rad += test::rotation_error_rad(in_doubt->T_camera_hand, truth) / 24;
    }
  EXPECT_LT(by_all_rad, 0.8 * by_tips_rad);
  EXPECT_LT(by_all_rad, deg(8));
  EXPECT_LT(in_doubt_rad, 0.6 * by_all_rad);
}

struct Consistency {
  double nees = 0;  ///< mean of the normalised squared error: 6 when the covariance is true
  double reduced_chi2 = 0;
};

/// Mean over views of 45 degrees of tilt of a hand that is off its model by `times` what the
/// settings say, each point by itself.
Consistency consistency(bool valleys, PoseMethod method, double times, int n, std::mt19937& rng) {
  PoseConfig config;
  config.method = method;
  HandModel hand = rendered_hand();
  hand.has_valleys = valleys;
  const double spread_sigma_rad =
      method == PoseMethod::tips ? 0.0 : times * config.spread_sigma_rad;
  const double tip_sigma_m = times * config.tip_sigma_m;
  const double tip_along_m = valleys ? times * config.tip_along_m : 0.0;
  const double relief_sigma_m = times * config.relief_sigma_m;
  std::uniform_real_distribution<double> axis(0, 2 * std::numbers::pi);
  Consistency sum;
  for (int i = 0; i < n; ++i) {
    std::array<double, kFingerCount> turned;
    for (double& t : turned) t = test::gauss(rng, spread_sigma_rad);
    HandModel actual = with_spread(hand, turned);
    for (int k = 0; k < kFingerCount; ++k)
      actual.tips_m.col(k) +=
          Eigen::Vector3d(test::gauss(rng, tip_sigma_m), test::gauss(rng, tip_sigma_m),
                          test::gauss(rng, relief_sigma_m)) +
          test::gauss(rng, tip_along_m) * hand.directions().col(k);
    const Eigen::Isometry3d truth = hand_at(0.45, deg(45), axis(rng));
    const double wander_m = config.valley_wander_m * (1 - std::cos(deg(45)));
    for (int k = 0; k < kValleyCount; ++k) {
      const double across_m = times * std::hypot(config.valley_sigma_m, wander_m);
      const Eigen::Vector3d along = hand.valley_directions().col(k);
      actual.valleys_m.col(k) +=
          test::gauss(rng, config.valley_stretch * across_m) * along +
          test::gauss(rng, across_m) * along.cross(Eigen::Vector3d::UnitZ()) +
          test::gauss(rng, relief_sigma_m) * Eigen::Vector3d::UnitZ();
    }
    for (int k = 0; k < kFingerCount; ++k)
      for (auto* const points_m : {&actual.axis_ends_m, &actual.axis_roots_m})
        points_m->col(k) += Eigen::Vector3d(test::gauss(rng, times * config.axis_sigma_m),
                                            test::gauss(rng, times * config.axis_sigma_m),
                                            test::gauss(rng, relief_sigma_m));
    HandObservation seen = test::project(actual, rendered_camera(), truth, tip_radius_m(method));
    test::add_noise(seen, 0.5, rng);
    // A weak prior: which of the planar solutions it is, no more.
    const PosePrior prior = expecting(truth, deg(10), 0.03);
    const auto pose = estimate_pose(seen, hand, rendered_camera(), config, prior);
    if (!pose) continue;
    const auto error = test::pose_error(truth, pose->T_camera_hand);
    sum.nees += error.dot(pose->covariance.ldlt().solve(error)) / n;
    sum.reduced_chi2 += pose->reduced_chi2 / n;
  }
  return sum;
}

TEST(Covariance, TellsTheTruth) {
  auto rng = test::random_for("Covariance.TellsTheTruth");
  // 6 where it is exact. The errors of a real hand's points are alike and disagree less than these,
  // which are independent: here it is on the cautious side.
  for (const auto& [valleys, method] :
       {std::pair{true, PoseMethod::points}, std::pair{true, PoseMethod::outline},
        std::pair{false, PoseMethod::tips}})
    for (const double times : {0.5, 1.0, 2.0}) {
      const Consistency c = consistency(valleys, method, times, 600, rng);
      EXPECT_GT(c.nees, 1.4) << valleys << int(method) << ' ' << times;
      EXPECT_LT(c.nees, 5.0) << valleys << int(method) << ' ' << times;
      if (times == 1) {
        EXPECT_NEAR(c.reduced_chi2, 1.0, 0.15) << valleys << int(method);
      }
    }
}

TEST(Covariance, GrowsWithOneWrongTip) {
  auto rng = test::random_for("Covariance.GrowsWithOneWrongTip");
  const HandModel hand = without_valleys(rendered_hand());
  std::uniform_real_distribution<double> axis(0, 2 * std::numbers::pi);
  int confident = 0;
  const int n = 300;
  for (int i = 0; i < n; ++i) {
    const Eigen::Isometry3d truth = hand_at(0.45, deg(35), axis(rng));
    HandObservation seen = test::project(hand, rendered_camera(), truth);
    test::add_noise(seen, 0.7, rng);
    const double direction = axis(rng);
    seen.tips[i % 5].px += 25 * Eigen::Vector2d(std::cos(direction), std::sin(direction));
    const auto pose = estimate_pose(seen, hand, rendered_camera());
    if (!pose) continue;
    const bool wrong = test::rotation_error_rad(pose->T_camera_hand, truth) > deg(8);
    if (wrong && sigma_rotation_rad(pose->covariance) < deg(3)) ++confident;
  }
  // With five tips a wrong thumb or little finger can look exactly like another pose: those few
  // cannot be told from one frame.
  EXPECT_LE(confident, n / 20);
}

TEST(Covariance, OneWrongPointAmongNineIsLeftOut) {
  auto rng = test::random_for("Covariance.OneWrongPointAmongNineIsLeftOut");
  const HandModel hand = rendered_hand();
  std::uniform_real_distribution<double> axis(0, 2 * std::numbers::pi);
  int good = 0;
  const int n = 100;
  for (int i = 0; i < n; ++i) {
    const Eigen::Isometry3d truth = hand_at(0.45, deg(35), axis(rng));
    HandObservation seen = test::project(hand, rendered_camera(), truth);
    test::add_noise(seen, 0.7, rng);
    const double direction = axis(rng);
    ObservedPoint& wrong = i % 9 < 5 ? seen.tips[i % 9] : seen.valleys[i % 9 - 5];
    wrong.px += 60 * Eigen::Vector2d(std::cos(direction), std::sin(direction));
    const auto pose = estimate_pose(seen, hand, rendered_camera());
    if (pose && test::rotation_error_rad(pose->T_camera_hand, truth) < deg(4)) ++good;
  }
  EXPECT_GE(good, 80) << "valleys are vague along the fingers: fewer points to tell it by";
}

TEST(Relief, TheMirroredOneTiltsTheHandAndTheMeanSaysSo) {
  const HandModel hand = rendered_hand();
  HandModel palm = hand;
  palm.tips_m.row(2) *= -1;
  palm.valleys_m.row(2) *= -1;
  palm.axis_ends_m.row(2) *= -1;
  palm.axis_roots_m.row(2) *= -1;
  const Eigen::Isometry3d truth = hand_at(0.45, deg(40), deg(60));
  const HandObservation seen = test::project(palm, rendered_camera(), truth);
  PosePrior model, mirrored, unknown;
  mirrored.relief_probability = 0;
  unknown.relief_probability = 0.5;
  const auto wrong = estimate_pose(seen, hand, rendered_camera(), {}, model);
  const auto right = estimate_pose(seen, hand, rendered_camera(), {}, mirrored);
  const auto mean = estimate_pose(seen, hand, rendered_camera(), {}, unknown);
  ASSERT_TRUE(wrong && right && mean);
  EXPECT_LT(test::rotation_error_rad(right->T_camera_hand, truth), 1e-6);
  const double error = test::rotation_error_rad(wrong->T_camera_hand, truth);
  EXPECT_GT(error, deg(1.0));
  EXPECT_NEAR(test::rotation_error_rad(mean->T_camera_hand, truth), 0.5 * error, 0.01 * error);
  EXPECT_GT(sigma_rotation_rad(mean->covariance), sigma_rotation_rad(right->covariance));
  const Matrix6d lasting = mean->covariance - mean->noise_covariance;
  EXPECT_GT(lasting.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), 0)
      << "the noise is a part of the covariance";
  EXPECT_LT(mean->relief_log_ratio, 0.0) << "the mirrored relief fits better";
  EXPECT_EQ(wrong->relief_log_ratio, 0.0);
}

}  // namespace
}  // namespace handyar
