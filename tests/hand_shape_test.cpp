// SPDX-License-Identifier: MIT
#include "handyar/hand_shape.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <numbers>

#include "drawn_hand.hpp"

namespace handyar {
namespace {

using test::deg;
using test::DrawnHand;
using test::DrawnMask;
using V = Eigen::Vector2d;

constexpr int kSize = 400;

/// The hand as an affine camera sees it: `px_per_m` large, turned by `roll`, tilted by `tilt` about
/// an axis in its plane.
Eigen::Affine2d view_of(double px_per_m, double roll, double tilt = 0, double axis = 0) {
  Eigen::Affine2d view = Eigen::Affine2d::Identity();
  const Eigen::Rotation2Dd about(axis);
  view.linear() = px_per_m * Eigen::Rotation2Dd(roll).toRotationMatrix() *
                  Eigen::Scaling(1.0, -1.0) * about.toRotationMatrix() *
                  Eigen::Scaling(1.0, std::cos(tilt)) * about.inverse().toRotationMatrix();
  view.translation() = V(kSize / 2.0, kSize / 2.0) - view.linear() * V(0.005, -0.01);
  return view;
}

/// What is found in a mask, as the search does it: with the deepest disc's radius and a smaller
/// one.
template <class Inside>
bool find(const Inside& inside, HandShape& shape) {
  DrawnMask drawn(kSize, kSize, inside);
  if (!drawn.trace_largest()) return false;
  drawn.region.keep_only(drawn.largest);
  CurvatureFinder finder;
  const Disc disc = drawn.region.deepest(drawn.largest);
  for (const float scale : {1.0f, 0.6f}) {
    finder.find(drawn.contour, scale * disc.radius);
    if (find_hand_shape(finder, drawn.contour, drawn.region.mask(), scale * disc.radius, {}, {},
                        shape))
      return true;
  }
  return false;
}

bool find(const DrawnHand& hand, const Eigen::Affine2d& view, HandShape& shape) {
  const Eigen::Affine2d hand_px = view.inverse();
  const auto inside = [&hand_px, distance_m = hand.distance_m()](int u, int v) {
    const V p = hand_px * V(u, v);
    return distance_m(p.x(), p.y()) < 0;
  };
  return find(inside, shape);
}

/// Largest distance of a tip found to its true place; also when fingers were taken for one another.
double worst_tip_px(const HandShape& shape, const DrawnHand& hand, const Eigen::Affine2d& view) {
  const HandModel model = average_adult_hand().for_layout(hand.layout);
  double worst = 0;
  for (int f = 0; f < kFingerCount; ++f) {
    const V truth = view * model.tips_m.col(f).head<2>();
    worst = std::max(worst, (shape.tips[f].cast<double>() - truth).norm());
  }
  return worst;
}

void expect_found(const DrawnHand& hand, const Eigen::Affine2d& view, double limit_px) {
  HandShape shape;
  ASSERT_TRUE(find(hand, view, shape));
  EXPECT_EQ(shape.layout, hand.layout);
  EXPECT_LT(worst_tip_px(shape, hand, view), limit_px);
}

constexpr Layout kLayouts[] = {Layout::thumb_right, Layout::thumb_left};

TEST(HandShape, IsFoundPointingAnywhere) {
  for (const Layout layout : kLayouts)
    for (int degrees = 0; degrees < 360; degrees += 15) {
      SCOPED_TRACE(std::string(name(layout)) + " turned by " + std::to_string(degrees));
      DrawnHand hand;
      hand.layout = layout;
      expect_found(hand, view_of(1300, deg(degrees)), 6);
    }
}

TEST(HandShape, IsFoundAtEverySize) {
  for (const double px_per_m : {500.0, 700.0, 1000.0, 1600.0})
    expect_found({}, view_of(px_per_m, 0.1), 5);
}

TEST(HandShape, IsFoundTilted) {
  for (const Layout layout : kLayouts)
    for (const double tilt : {15, 30})
      for (int axis = 0; axis < 180; axis += 30) {
        SCOPED_TRACE(std::to_string(tilt) + " degrees about " + std::to_string(axis));
        DrawnHand hand;
        hand.layout = layout;
        expect_found(hand, view_of(1300, 0.2, deg(tilt), deg(axis)), 7);
      }
}

TEST(HandShape, IsMostlyFoundTiltedBy45DegreesAndNeverWrongly) {
  int found = 0;
  for (const Layout layout : kLayouts)
    for (int axis = 0; axis < 180; axis += 30) {
      DrawnHand hand;
      hand.layout = layout;
      const Eigen::Affine2d view = view_of(1300, 0.2, deg(45), deg(axis));
      HandShape shape;
      if (!find(hand, view, shape)) continue;
      ++found;
      EXPECT_EQ(shape.layout, layout) << axis;
      EXPECT_LT(worst_tip_px(shape, hand, view), 7) << axis;
    }
  EXPECT_GE(found, 11) << "of 12";
}

/// Tips and valleys of a hand as an affine camera sees them.
HandShape seen(const HandModel& hand, const Eigen::Affine2d& view) {
  HandShape shape;
  shape.layout = hand.layout;
  shape.tip_seen.fill(true);
  shape.valley_seen.fill(true);
  for (int f = 0; f < kFingerCount; ++f)
    shape.tips[f] = (view * hand.tips_m.col(f).head<2>()).cast<float>();
  for (int k = 0; k < kValleyCount; ++k)
    shape.valleys[k] = (view * hand.valleys_m.col(k).head<2>()).cast<float>();
  return shape;
}

/// A hand with a thumb of its own.
HandModel measured_hand() {
  HandModel hand = average_adult_hand();
  hand.source = HandSource::checkerboard;
  hand.tips_m(0, 0) -= 0.012;
  hand.tips_m(1, 0) -= 0.010;
  hand.valleys_m.row(0) << 0.036, 0.011, -0.014, -0.037;
  hand.valleys_m.row(1) << -0.019, 0.018, 0.019, 0.001;
  hand.has_valleys = true;
  return hand;
}

TEST(HandShapeModel, AMeasuredHandIsItsOwnMeanInBothLayouts) {
  const HandModel hand = measured_hand();
  const HandShapeModel own(hand, {}), general;
  for (const Layout layout : kLayouts) {
    HandShape shape = seen(hand.for_layout(layout), view_of(1300, 0.4, deg(40), deg(20)));
    EXPECT_TRUE(own.fit({}, shape));
    EXPECT_LT(shape.deviation, 1e-3f);
    EXPECT_TRUE(general.fit({}, shape));
    EXPECT_GT(shape.deviation, 0.2f);
  }
}

TEST(HandShapeModel, KnowsAnotherHandFromTheMeasuredOne) {
  const HandShapeModel own(measured_hand(), {}), general;
  HandModel longer = measured_hand();
  longer.tips_m(0, 0) += 0.030;  // the thumb continues along a table's edge
  HandShape shape = seen(longer, view_of(1300, 0.4));
  own.fit({}, shape);
  const float against_own = shape.deviation;
  general.fit({}, shape);
  EXPECT_GT(against_own, 1.3f * shape.deviation);
}

TEST(OwnShape, OfAModelKnowsItsFingersFromTheFirstFrameOn) {
  HandModel hand = measured_hand();
  for (const bool valleys : {true, false}) {
    hand.has_valleys = valleys;
    const OwnShape modelled(hand);
    for (const Layout layout : kLayouts) {
      const Eigen::Affine2d view = view_of(1300, 0.4, deg(40), deg(20));
      EXPECT_LT(modelled.odd_tip(seen(measured_hand().for_layout(layout), view), 0.012f).off_m,
                valleys ? 0.001 : 0.015);
      HandModel longer = measured_hand();
      longer.tips_m(0, 0) += 0.050;  // the thumb continues along a table's edge
      const auto odd = modelled.odd_tip(seen(longer.for_layout(layout), view), 0.012f);
      EXPECT_EQ(odd.finger, 0);
      EXPECT_GT(odd.off_m, 0.035);
    }
  }
}

TEST(HandShapeModel, WithoutMeasuredValleysIsHandsInGeneral) {
  HandModel hand = measured_hand();
  hand.has_valleys = false;
  const HandShapeModel own(hand, {}), general;
  HandShape shape = seen(measured_hand(), view_of(1300, 0.4));
  EXPECT_TRUE(own.fit({}, shape));
  const float deviation = shape.deviation;
  EXPECT_TRUE(general.fit({}, shape));
  EXPECT_EQ(shape.deviation, deviation);
}

/// A hand that was tracked for half a second, seen as `view` has it.
OwnShape learned(const HandModel& hand, const HandShapeModel& model) {
  OwnShape own;
  for (int frame = 0; frame < 15; ++frame) {
    HandShape shape = seen(hand, view_of(1300, 0.02 * frame, deg(2.0 * frame), deg(20)));
    model.fit({}, shape);
    own.learn(shape, 0.05f);
  }
  return own;
}

TEST(OwnShape, KnowsAMisreadFingerFromAnotherView) {
  const HandModel hand = measured_hand();
  const HandShapeModel model;
  const OwnShape own = learned(hand, model);
  const Eigen::Affine2d view = view_of(1000, 1.2, deg(35), deg(70));
  HandShape shape = seen(hand, view);
  EXPECT_EQ(own.odd_tip(shape, 0.005f).off_m, 0);
  for (int f = 0; f < kFingerCount; ++f)
    for (const double by_m : {-0.03, 0.03}) {
      HandModel misread = hand;
      misread.tips_m.col(f) *= 1 + by_m / hand.tips_m.col(f).norm();
      HandShape wrong = seen(misread, view);
      EXPECT_EQ(own.odd_tip(wrong, 0.005f).finger, f) << by_m;
      EXPECT_GT(own.odd_tip(wrong, 0.005f).off_m, HandShapeConfig{}.misread_m) << by_m;
      wrong.tip_seen[f] = false;
      ASSERT_TRUE(own.infer_tip(f, wrong));
      EXPECT_LT((wrong.tips[f] - shape.tips[f]).norm(), 0.002f * 1000) << f;
    }
}

TEST(OwnShape, AllowsFingersToMoveALittle) {
  const HandModel hand = measured_hand();
  const HandShapeModel model;
  const OwnShape own = learned(hand, model);
  for (int f = 0; f < kFingerCount; ++f) {
    HandModel moved = hand;
    moved.tips_m(0, f) += 0.010;
    const OwnShape::OddTip odd = own.odd_tip(seen(moved, view_of(1000, 0.3)), 0.005f);
    EXPECT_EQ(odd.finger, f);
    EXPECT_GT(odd.off_m, 0.005) << f;
    EXPECT_LT(odd.off_m, HandShapeConfig{}.misread_m) << f;
    EXPECT_NEAR(odd.px_per_m, 1000, 50);
  }
}

TEST(OwnShape, SaysNothingBeforeItKnowsEnough) {
  const HandModel hand = measured_hand();
  const HandShapeModel model;
  OwnShape own;
  HandShape shape = seen(hand, view_of(1300, 0));
  model.fit({}, shape);
  own.learn(shape, 0.05f);
  shape.tips[0] *= 1.5f;
  EXPECT_EQ(own.odd_tip(shape, 0.005f).finger, -1);
  EXPECT_FALSE(own.infer_tip(0, shape));
  OwnShape known = learned(hand, model);
  known.reset();
  EXPECT_FALSE(known.infer_tip(0, shape));
}

TEST(HandShape, ExpectsItselfWhereItIs) {
  const DrawnHand hand;
  const Eigen::Affine2d view = view_of(1300, 0.3);
  HandShape shape;
  ASSERT_TRUE(find(hand, view, shape));
  ExpectedRegion expected;
  expected.ratios.resize(kSize * kSize);
  shape.expect(kSize, kSize, expected);
  const auto distance_m = hand.distance_m();
  int inside = 0, outside = 0;
  for (int v = 0; v < kSize; ++v)
    for (int u = 0; u < kSize; ++u) {
      const int place = expected.row(v)[u / expected.cell];
      const V at = view.inverse() * V(u, v);
      const double distance_px = 1300 * distance_m(at.x(), at.y());
      inside += place == ExpectedRegion::kInside;
      outside += place == ExpectedRegion::kOutside;
      if (place == ExpectedRegion::kInside) {
        EXPECT_LT(distance_px, 12) << u << " " << v;
      }
      if (place < 0) {
        EXPECT_GT(distance_px, 2) << u << " " << v;
      }
    }
  EXPECT_GT(inside, kSize * kSize / 20);
  EXPECT_GT(outside, kSize * kSize / 4);
}

TEST(HandShape, IsFoundWithoutItsForearm) {
  DrawnHand hand;
  hand.forearm = false;
  expect_found(hand, view_of(1300, 0.3), 6);
}

TEST(HandShape, FewerFingersAreNotFound) {
  HandShape shape;
  for (int folded = 0; folded < kFingerCount; ++folded) {
    DrawnHand hand;
    hand.fold[folded] = 1;
    EXPECT_FALSE(find(hand, view_of(1300, 0.1), shape)) << "without " << kFingerNames[folded];
  }
  DrawnHand fist;
  fist.make_fist();
  EXPECT_FALSE(find(fist, view_of(1300, 0.1), shape));
  DrawnHand three;
  three.fold = {1, 0, 0, 0, 1};
  EXPECT_FALSE(find(three, view_of(1300, 0.1), shape));
}

TEST(HandShape, OtherThingsAreNotFound) {
  HandShape shape;
  const V center(200, 200);
  for (const double height : {1.0, 1.3, 1.6})
    EXPECT_FALSE(find(
        [&](int u, int v) { return V((u - 200) / 90.0, (v - 200) / (90 * height)).norm() < 1; },
        shape))
        << "a disc or a face";
  for (const int arms : {3, 4, 5, 6, 7}) {
    const auto star = [&](int u, int v) {
      bool inside = (V(u, v) - center).norm() < 45;
      for (int i = 0; i < arms; ++i) {
        const double angle = 0.2 + 2 * std::numbers::pi * i / arms;
        const V end = center + 140 * V(std::cos(angle), std::sin(angle));
        inside = inside || test::capsule_distance({u, v}, center, end, 12) < 0;
      }
      return inside;
    };
    EXPECT_FALSE(find(star, shape)) << "a star with " << arms << " arms";
  }
  for (const int prongs : {4, 5, 6}) {
    const auto fork = [&](int u, int v) {
      bool inside = test::capsule_distance({u, v}, {200, 240}, {200, 390}, 15) < 0;
      for (int i = 0; i < prongs; ++i) {
        const double x = 200 + 32 * (i - (prongs - 1) / 2.0);
        inside = inside || test::capsule_distance({u, v}, {x, 230}, {x, 60}, 9) < 0 ||
                 test::capsule_distance({u, v}, {x, 230}, {200, 230}, 25) < 0;
      }
      return inside;
    };
    EXPECT_FALSE(find(fork, shape)) << "a fork with " << prongs << " prongs";
  }
}

TEST(HandShape, MapsTheAverageHandIntoTheImage) {
  for (const Layout layout : kLayouts) {
    DrawnHand hand;
    hand.layout = layout;
    const Eigen::Affine2d view = view_of(1300, 0.4, deg(25), 1);
    HandShape shape;
    ASSERT_TRUE(find(hand, view, shape));
    EXPECT_LT((shape.palm().cast<double>() - view * V(0, -0.035)).norm(), 15);
    EXPECT_NEAR(shape.finger_width, 1300 * 0.017, 5);
    const HandReach reach(shape);
    for (int f = 0; f < kFingerCount; ++f) {
      EXPECT_TRUE(reach.holds(shape.tips[f]));
      EXPECT_TRUE(shape.bounds().contains(shape.tips[f]));
    }
    EXPECT_TRUE(reach.holds(shape.palm()));
    EXPECT_FALSE(reach.holds(shape.tips[2] + 3 * (shape.tips[2] - shape.palm())));
  }
}

TEST(HandShape, MovesAndScalesAsAWhole) {
  HandShape shape;
  ASSERT_TRUE(find(DrawnHand{}, view_of(1300, 0.1), shape));
  const HandShape moved = shape.transformed(2, {10, -20});
  const auto move = [](const Eigen::Vector2f& p) {
    return Eigen::Vector2f(2 * p + Eigen::Vector2f(10, -20));
  };
  EXPECT_LT((moved.palm() - move(shape.palm())).norm(), 1e-2f);
  EXPECT_LT((moved.tips[3] - move(shape.tips[3])).norm(), 1e-3f);
  EXPECT_NEAR(moved.palm_radius(), 2 * shape.palm_radius(), 1e-3);
  EXPECT_FALSE(moved.resembles(shape));
  EXPECT_TRUE(shape.transformed(1, {5, 5}).resembles(shape));
  HandShape other = shape;
  other.layout = opposite(shape.layout);
  EXPECT_FALSE(other.resembles(shape));
}

}  // namespace
}  // namespace handyar
