// SPDX-License-Identifier: MIT
#include "handyar/stages/align.hpp"

#include <gtest/gtest.h>

#include "align/boundary_line.hpp"
#include "drawn_hand.hpp"
#include "track/hand_prior.hpp"
#include "track/hypotheses.hpp"
#include "track/start_pose.hpp"
#include "track/turning.hpp"

namespace handyar {
namespace {

using test::deg;
using test::gauss;

/// A drawn hand, and an aligner that has learned its colours.
struct Scene {
  explicit Scene(Appearance appearance = {}, int width_px = 640, int height_px = 480)
      : camera(Camera::from_field_of_view(width_px, height_px)), picture(width_px, height_px) {
    hand.appearance = appearance;
    hand.state.T_camera_hand = test::hand_at(0.4, deg(25), deg(140));
    picture.texture(24, "Scene");
    picture.paint(hand, camera, hand.state.T_camera_hand);
    picture.add_noise(4, 1);
    aligner.learn(picture.view(), camera, appearance, hand.state, 0, 1);
  }

  HandPrior prior(const HandState& around) const {
    return prior_around(around, Person(average_adult_hand()), kLongAgo_s, {});
  }

  Alignment align(const HandState& start) {
    return aligner.align(picture.view(), camera, hand.appearance, start, prior(start), kFarSteps);
  }

  Camera camera;
  test::DrawnHand hand;
  test::Picture picture;
  Aligner aligner;
};

class AlignerOf : public testing::TestWithParam<Appearance> {};

TEST_P(AlignerOf, ComesBackFromStartsThatAreOff) {
  Scene scene(GetParam());
  std::mt19937 rng = test::random_for("starts");
  for (int i = 0; i < 20; ++i) {
    HandState start = scene.hand.state;
    start.T_camera_hand.linear() = (Eigen::AngleAxisd(deg(8), test::gauss3(rng, 1).normalized()) *
                                    start.T_camera_hand.linear())
                                       .eval();
    start.T_camera_hand.translation() += test::gauss3(rng, 0.004);
    const Alignment a = scene.align(start);
    ASSERT_TRUE(a.valid);
    const auto error = test::pose_error(scene.hand.state.T_camera_hand, a.state.T_camera_hand);
    EXPECT_LT(error.head<3>().norm(), deg(2.5)) << i;
    EXPECT_LT(a.rms_px, 1.0);
    EXPECT_GT(a.log_ratio, 15);
    // The covariance tells the truth, within what a Gaussian's tails allow.
    const HandMatrix covariance = a.information.inverse();
    const Matrix6d pose = covariance.topLeftCorner<6, 6>();
    EXPECT_LT(error.dot(pose.ldlt().solve(error)), 30) << i;
  }
}
INSTANTIATE_TEST_SUITE_P(Appearances, AlignerOf,
                         testing::Values(Appearance{Face::palm, Layout::thumb_right},
                                         Appearance{Face::palm, Layout::thumb_left},
                                         Appearance{Face::back, Layout::thumb_right},
                                         Appearance{Face::back, Layout::thumb_left}));

TEST(Aligner, AnEmptyRoomSpeaksAgainstAHand) {
  Scene scene;
  test::Picture room(640, 480);
  room.texture(24, "Scene");
  room.add_noise(4, 2);
  const Alignment a =
      scene.aligner.align(room.view(), scene.camera, scene.hand.appearance, scene.hand.state,
                          scene.prior(scene.hand.state), kNearSteps);
  EXPECT_TRUE(!a.valid || a.log_ratio < 6) << a.log_ratio;
}

TEST(Aligner, HandsAndRoomsOfAnyColourAreToldApart) {
  for (const test::Bgr& hand : {test::Bgr{255, 255, 255}, {0, 0, 0}, {255, 0, 255}, {0, 255, 0}}) {
    Scene scene;
    scene.picture = test::Picture(
        640, 480,
        {std::uint8_t(255 - hand[0]), std::uint8_t(255 - hand[1]), std::uint8_t(255 - hand[2])});
    scene.picture.paint(scene.hand, scene.camera, scene.hand.state.T_camera_hand, hand);
    scene.aligner.forget();
    scene.aligner.learn(scene.picture.view(), scene.camera, scene.hand.appearance, scene.hand.state,
                        0, 1);
    const Alignment a = scene.align(scene.hand.state);
    ASSERT_TRUE(a.valid);
    EXPECT_GT(a.log_ratio, 20);
    EXPECT_LT(test::rotation_error_rad(scene.hand.state.T_camera_hand, a.state.T_camera_hand),
              deg(2));
  }
}

TEST(Aligner, OutlineAndColoursTellWhichPartsAreThere) {
  Scene scene;
  test::DrawnHand thumb_in = scene.hand;
  thumb_in.state.posture = {{-0.75, 0, 0, 0, 0}, {0.95, 0, 0, 0, 0}};
  // The box lies behind other fingers, too. A thumb in a light of its own is there.
  enum class Shown { open, in_its_own_light, folded, before_a_box };
  for (const Shown shown :
       {Shown::open, Shown::in_its_own_light, Shown::folded, Shown::before_a_box}) {
    const bool there = shown == Shown::open || shown == Shown::in_its_own_light;
    const Eigen::Isometry3d& T = scene.hand.state.T_camera_hand;
    scene.picture = test::Picture(640, 480);
    scene.picture.texture(24, "Scene");
    if (shown == Shown::before_a_box)
      scene.picture.paint(scene.hand, scene.camera, Eigen::Translation3d(0.01, 0.01, 0) * T,
                          {60, 60, 190});
    if (shown == Shown::in_its_own_light)
      scene.picture.paint(scene.hand, scene.camera, T, {60, 60, 190});
    scene.picture.paint(shown == Shown::open ? scene.hand : thumb_in, scene.camera, T);
    scene.picture.add_noise(4, 1);
    // As one that takes what lies there for an open hand has learned them.
    scene.aligner.forget();
    scene.aligner.learn(scene.picture.view(), scene.camera, scene.hand.appearance, scene.hand.state,
                        0, 1);
    const Alignment a = scene.align(scene.hand.state);
    ASSERT_TRUE(a.valid);
    const PartRatios inside = scene.aligner.ratios_inside(scene.picture.view(), scene.camera,
                                                          scene.hand.appearance, a.state);
    EXPECT_EQ(is_whole(a, inside), there);
    if (shown == Shown::in_its_own_light) {
      EXPECT_LT(inside[0], -1) << "more colours lie behind";
    }
    for (int part = 0; part <= kFingerCount; ++part)
      EXPECT_EQ(inside[part] + a.part_log_ratios[part] < 0, !there && part == 0)
          << static_cast<int>(shown) << ", part " << part << ": " << inside[part] << " inside, "
          << a.part_log_ratios[part] << " at its outline";
  }
  HandState away = scene.hand.state;
  away.T_camera_hand.translation().x() += 5;
  for (const double of_part :
       scene.aligner.ratios_inside(scene.picture.view(), scene.camera, scene.hand.appearance, away))
    EXPECT_EQ(of_part, 0) << "nobody knows";
}

TEST(OutlineColors, NewColoursSayLessOfAPartWhereTheHandHasOthers) {
  const OutlineColors::Shares of_neither, of_hand{0.1f, 0};
  EXPECT_EQ(of_neither.novelty(), 1);
  EXPECT_LT(of_hand.novelty(), 0.01);
  EXPECT_NEAR(of_neither.log_ratio(0), -std::log(3), 0.01) << "a part may have its own light";
  EXPECT_NEAR(of_neither.log_ratio(1.0f / 6), -std::log(2), 0.01);
  EXPECT_NEAR(of_neither.log_ratio(0.7f), 0, 0.01) << "noise is everywhere";
}

TEST(Belief, AHandIsAsLikelyAsTheLessOfWhatOutlineAndColoursInsideSay) {
  const BeliefConfig belief;
  Alignment laid;
  laid.part_log_ratios.fill(3);
  laid.log_ratio = 18;
  const auto evidence = [&](double of_each_part) {
    PartRatios inside;
    inside.fill(of_each_part);
    return belief.evidence_of(laid, inside);
  };
  EXPECT_EQ(evidence(7), belief.most_frame());
  EXPECT_NEAR(evidence(2), belief.says(12), 1e-12);
  EXPECT_LT(evidence(0.5), 0) << "an outline of a hand, filled with what is anywhere";
  EXPECT_EQ(evidence(-4), -belief.most_frame()) << "no part is there";
}

TEST(Aligner, WhereAFingerLiesOnAnotherColoursTellOfNeither) {
  Scene scene;
  constexpr int kRing = 3;
  HandState apart = scene.hand.state, on_middle = apart;
  on_middle.posture.abduction_rad[kRing] = 1.7 * closing_rad()[kRing];
  const auto inside = [&](const HandState& state) {
    return scene.aligner.ratios_inside(scene.picture.view(), scene.camera, scene.hand.appearance,
                                       state);
  };
  EXPECT_GT(inside(apart)[kRing], 4);
  EXPECT_LT(inside(on_middle)[kRing], 1);
}

TEST(Aligner, ARoughFigureBesideAThumbDoesNotTakeWhatIsThereForIt) {
  Scene scene;
  test::DrawnHand off = scene.hand;
  off.state.posture.abduction_rad[0] = 0.3;
  scene.picture = test::Picture(640, 480);
  scene.picture.texture(24, "Scene");
  scene.picture.paint(off, scene.camera, off.state.T_camera_hand);
  scene.picture.add_noise(4, 1);
  scene.aligner.forget();
  scene.aligner.learn(scene.picture.view(), scene.camera, scene.hand.appearance, scene.hand.state,
                      0, kFarSteps.coarsest);
  const Alignment a = scene.align(scene.hand.state);
  ASSERT_TRUE(a.valid);
  EXPECT_NEAR(a.state.posture.abduction_rad[0], 0.3, 0.08);
}

TEST(Aligner, FurrowsAreLookedForWhereFingersLieTogether) {
  Scene scene;
  const HandView view(scene.camera, scene.hand.state.T_camera_hand.translation());
  const auto furrows = [&](const HandState& state) {
    const Silhouette silhouette(scene.hand.appearance, state, view);
    Silhouette::Anchors anchors;
    const int count = silhouette.choose(8, anchors);
    std::array<int, kFingerCount> of_finger{};
    for (int i = 0; i < count; ++i) {
      if (!anchors[i].furrow) continue;
      ++of_finger[finger_of(anchors[i].a)];
      const Eigen::Vector2f px = silhouette.place(anchors[i]).px;
      EXPECT_LT(silhouette.distance_px(px), 1);
      EXPECT_EQ(silhouette.derivative(anchors[i], silhouette.place(anchors[i]))[kBoundaryAt], 0);
    }
    return of_finger;
  };
  HandState together = scene.hand.state;
  for (int f = 1; f < kFingerCount; ++f) together.posture.abduction_rad[f] = 1.3 * closing_rad()[f];
  EXPECT_EQ(furrows(scene.hand.state), (std::array<int, kFingerCount>{}));
  const auto of_finger = furrows(together);
  EXPECT_EQ(of_finger[0], 0);
  for (int f = 1; f < kFingerCount; ++f) EXPECT_GT(of_finger[f], 2) << f;
}

TEST(BoundaryLine, AFurrowIsWhereItIsDarkerThanOnBothSides) {
  const Camera camera = Camera::from_field_of_view(640, 480);
  const HandView view(camera, {0, 0, 0.4});
  const Eigen::Vector2f at = view.from_frame({320, 240});
  const OutlineColors colors;  // that tell nothing
  for (const double furrow_px : {-4.0, -3.0, 0.0, 3.0, 4.0}) {
    test::Picture picture(640, 480, test::kSkinColor);
    // On one side it is lighter: a step in luma alone is none.
    picture.paint([](const Eigen::Vector2d& px) { return 327 - px.x(); }, 1, {140, 170, 225});
    picture.paint([&](const Eigen::Vector2d& px) { return std::abs(px.x() - 320 - furrow_px) - 1; },
                  1, {80, 100, 150});
    picture.add_noise(2, 1);
    const ImageView frame = picture.view();
    const PixelReader reader(frame);
    const BoundaryLine line(reader, view, {at, {1, 0}}, 1.0f, 10, 10);
    const Boundary found = line.find_furrow(colors, 1);
    // Furrows elsewhere are not ruled out: the mean is drawn to the middle.
    EXPECT_LT(std::abs(found.mean_px), std::abs(furrow_px) + 0.5) << furrow_px;
    EXPECT_GE(found.mean_px * furrow_px, 0.5 * furrow_px * furrow_px) << furrow_px;
    EXPECT_EQ(found.log_ratio > 0, furrow_px == 0) << furrow_px;
  }
  const test::Picture even(640, 480, test::kSkinColor);
  const ImageView frame = even.view();
  const PixelReader reader(frame);
  const Boundary found =
      BoundaryLine(reader, view, {at, {1, 0}}, 1.0f, 10, 10).find_furrow(colors, 1);
  EXPECT_GT(found.sigma_px, 3);
  EXPECT_NEAR(found.log_ratio, 0, 0.1);
}

TEST(Aligner, TheOutlineReportedIsWhereTheHandEnds) {
  Scene scene;
  const Alignment a = scene.align(scene.hand.state);
  ASSERT_TRUE(a.valid);
  const auto outline = scene.aligner.outline();
  ASSERT_GT(outline.size(), 60u);
  int beside = 0;
  for (const OutlinePoint& p : outline) {
    EXPECT_NEAR(p.normal.norm(), 1, 0.1);
    beside += std::abs(p.found_px) > 2;
  }
  EXPECT_LT(beside, 0.1 * static_cast<double>(outline.size()));
}

TEST(Aligner, WhatLiesOutsideTheFrameOrBehindTheCameraIsNoHand) {
  Scene scene;
  HandState away = scene.hand.state, behind = away;
  away.T_camera_hand.translation().x() += 5;
  behind.T_camera_hand.translation().z() *= -1;
  EXPECT_FALSE(scene.align(away).valid);
  EXPECT_FALSE(scene.align(behind).valid);
}

constexpr Appearance kPalm{Face::palm, Layout::thumb_right};

/// Fingertips and roots of a hand in the picture, each off by what `off_px` draws.
template <class Off>
RoughFingers fingers_of(const HandState& state, const Camera& camera, const Off& off_px) {
  const PosedFigure hand = posed_figure(kPalm, state);
  const auto shown = [&](const Eigen::Vector3d& p_m) -> Eigen::Vector2d {
    // One after the other: compilers draw a call's arguments in different orders.
    const double off_y_px = off_px(), off_x_px = off_px();
    return camera.project(state.T_camera_hand * p_m) + Eigen::Vector2d(off_x_px, off_y_px);
  };
  RoughFingers seen;
  for (int f = 0; f < kFingerCount; ++f) {
    seen.tips_px[f] = shown(hand.tips_m.col(f));
    seen.roots_px[f] = shown(hand.centres_m.col(sphere_of(f, 0)));
  }
  return seen;
}

TEST(StartPose, RoughFingersAreEnough) {
  const Camera camera = test::rendered_camera();
  std::mt19937 rng = test::random_for("rough");
  for (int i = 0; i < 50; ++i) {
    HandState truth;
    truth.T_camera_hand = test::hand_at(0.45, deg(15), gauss(rng, 3), {0.05, 0.01});
    RoughFingers seen = fingers_of(truth, camera, [&] { return gauss(rng, 8); });
    seen.sigma_px = 8;
    const PosedFigure hand = posed_figure(kPalm, HandState{});
    const auto error = test::pose_error(truth.T_camera_hand, start_pose(seen, hand, camera, 0.35));
    EXPECT_LT(error.head<3>().norm(), deg(60)) << "tilt is hardly seen";
    EXPECT_LT(error.tail<3>().norm(), 0.1);
  }
}

TEST(StartPose, FingersBeginWhereTheirTipsAreSeen) {
  const Camera camera = test::rendered_camera();
  for (const double thumb_rad : {-0.3, 0.0, 0.4}) {
    HandState truth;
    truth.T_camera_hand = test::hand_at(0.45, deg(5), deg(40), {0.02, 0.01});
    truth.posture.abduction_rad = {thumb_rad, 0.05, 0, 0, -0.1};
    RoughFingers seen = fingers_of(truth, camera, [] { return 0; });
    seen.sigma_px = 3;
    HandState start = truth;
    start.posture = {};
    spread_as_seen(seen, kPalm, camera, start);
    for (int f = 0; f < kFingerCount; ++f)
      EXPECT_NEAR(start.posture.abduction_rad[f], truth.posture.abduction_rad[f], 0.06)
          << f << ", thumb turned by " << thumb_rad;
  }
}

TEST(Turning, TheOtherPlanarSolutionMirrorsTheTiltAndTwiceIsTheFirst) {
  const Eigen::Isometry3d T = test::hand_at(0.4, deg(30), deg(20));
  const Eigen::Isometry3d other = other_planar_solution(T);
  const Eigen::Vector3d sight = T.translation().normalized();
  EXPECT_NEAR(T.linear().col(2).dot(sight), other.linear().col(2).dot(sight), 1e-9);
  EXPECT_GT(test::rotation_error_rad(T, other), deg(20));
  EXPECT_LT(test::rotation_error_rad(T, other_planar_solution(other)), 1e-6);
}

TEST(Turning, BeyondItsEdgeAHandLiesAndMovesMirroredInDepthAndTwiceIsTheFirst) {
  HandState state;
  state.T_camera_hand = test::hand_at(0.4, deg(82), deg(20));
  state.velocity << 0.3, -1, 0.5, 0, 0, 0;
  const HandState other = beyond_edge(state), again = beyond_edge(other);
  const double through_rad = turn_through_edge_rad(state.T_camera_hand);
  EXPECT_LT(through_rad, deg(40));
  EXPECT_NEAR(test::rotation_error_rad(state.T_camera_hand, other.T_camera_hand), through_rad,
              1e-6);
  EXPECT_NEAR(turn_through_edge_rad(other.T_camera_hand), through_rad, 1e-6);
  EXPECT_LT(test::rotation_error_rad(state.T_camera_hand, again.T_camera_hand), 1e-6);
  EXPECT_LT((state.velocity - again.velocity).norm(), 1e-9);
  // Both reach the edge at the same time.
  const double dt_s = 1e-4;
  EXPECT_NEAR(turn_through_edge_rad(state.pose_after(dt_s)),
              turn_through_edge_rad(other.pose_after(dt_s)), 1e-6);

  Appearance appearance;
  Eigen::Isometry3d T = other.T_camera_hand, shown = state.T_camera_hand;
  EXPECT_NE(turn_over(appearance, T), turn_over(appearance, shown)) << "one shows its other face";
  EXPECT_EQ(appearance.face, opposite(Appearance{}.face));
  EXPECT_EQ(appearance.layout, opposite(Appearance{}.layout));
}

}  // namespace
}  // namespace handyar
