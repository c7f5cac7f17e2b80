// SPDX-License-Identifier: MIT
#include "handyar/fingertips.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "drawn_mask.hpp"
#include "synthetic_hand.hpp"

namespace handyar {
namespace {

using test::deg;
using test::DrawnMask;
using V = Eigen::Vector2d;

constexpr int kSize = 321;
constexpr double kPalmRadius = 45, kFingerRadius = 10, kReach = 135;

/// A finger on a palm, in any direction; with a small `corner` radius it ends bluntly.
struct Finger {
  V palm, direction;
  double corner = kFingerRadius;
  V tip() const { return palm + kReach * direction; }
  double distance(const V& p) const {
    const V d = p - palm, across(-direction.y(), direction.x());
    const V past(d.dot(direction) - (kReach - corner),
                 std::abs(d.dot(across)) - (kFingerRadius - corner));
    const double end = past.cwiseMax(0.0).norm() + std::min(past.maxCoeff(), 0.0) - corner;
    return std::min(d.norm() - kPalmRadius, std::max(end, -d.dot(direction)));
  }
};

template <class Shape>
DrawnMask draw(const Shape& shape, double scale = 1) {
  const int size = static_cast<int>(kSize * scale);
  return DrawnMask(size, size, [&](int u, int v) { return shape.distance(V(u, v) / scale) < 0; });
}

/// Errors (px) of the measured tip over many directions and places between pixels.
std::vector<double> tip_errors(FingertipMethod method, double corner = kFingerRadius,
                               float width = 2 * kFingerRadius) {
  std::mt19937 rng = test::random_for("tip_errors");
  std::uniform_real_distribution<double> between(0, 1);
  std::vector<double> errors;
  FingertipConfig config;
  config.method = method;
  CurvatureFinder finder(config);
  for (int degrees = 0; degrees < 360; degrees += 11) {
    const double angle = deg(degrees + between(rng));
    const Finger finger{
        {160 + between(rng), 160 + between(rng)}, {std::cos(angle), std::sin(angle)}, corner};
    DrawnMask drawn = draw(finger);
    if (!drawn.trace_largest()) continue;
    finder.find(drawn.contour, kPalmRadius);
    if (finder.tips().size() != 1) continue;
    const float arc = float(finder.tips()[0].sample) * finder.spacing();
    const Eigen::Vector2f tip =
        measure_tip(drawn.contour, arc, finger.palm.cast<float>(), width, method);
    errors.push_back((tip.cast<double>() - finger.tip()).norm());
  }
  std::ranges::sort(errors);
  return errors;
}

TEST(Fingertips, TheEllipseMeasuresATipToAFractionOfAPixel) {
  const auto errors = tip_errors(FingertipMethod::ellipse);
  ASSERT_EQ(errors.size(), 33u) << "one tip on each finger";
  RecordProperty("median_px", std::to_string(errors[errors.size() / 2]));
  RecordProperty("largest_px", std::to_string(errors.back()));
  EXPECT_LT(errors[errors.size() / 2], 0.5);
  EXPECT_LT(errors.back(), 1.5);
}

TEST(Fingertips, ABluntFingerEndsInItsMiddleNotAtACorner) {
  // Wider than a hand of this size has them, as when it points at the camera.
  const auto errors =
      tip_errors(FingertipMethod::ellipse, 0.5 * kFingerRadius, 1.5 * kFingerRadius);
  ASSERT_EQ(errors.size(), 33u);
  RecordProperty("median_px", std::to_string(errors[errors.size() / 2]));
  RecordProperty("largest_px", std::to_string(errors.back()));
  EXPECT_LT(errors[errors.size() / 2], 1);
  EXPECT_LT(errors.back(), 1.5);
}

TEST(Fingertips, CurvatureAloneMeasuresATipToAFewPixels) {
  const auto errors = tip_errors(FingertipMethod::curvature);
  ASSERT_EQ(errors.size(), 33u);
  RecordProperty("median_px", std::to_string(errors[errors.size() / 2]));
  RecordProperty("largest_px", std::to_string(errors.back()));
  EXPECT_LT(errors[errors.size() / 2], 2);
  EXPECT_LT(errors.back(), 4);
}

TEST(Fingertips, AMirroredFingerHasAMirroredTip) {
  const Finger finger{{160, 160}, {std::cos(deg(-70)), std::sin(deg(-70))}};
  DrawnMask one = draw(finger);
  DrawnMask other(kSize, kSize,
                  [&](int u, int v) { return finger.distance(V(kSize - 1 - u, v)) < 0; });
  CurvatureFinder finder;
  std::vector<Eigen::Vector2f> tips;
  for (DrawnMask* m : {&one, &other}) {
    ASSERT_TRUE(m->trace_largest());
    finder.find(m->contour, kPalmRadius);
    ASSERT_EQ(finder.tips().size(), 1u);
    const float arc = float(finder.tips()[0].sample) * finder.spacing();
    tips.push_back(
        measure_tip(m->contour, arc, {160, 160}, 2 * kFingerRadius, FingertipMethod::ellipse));
  }
  EXPECT_LT((Eigen::Vector2f(kSize - 1 - tips[1].x(), tips[1].y()) - tips[0]).norm(), 1.0f);
}

/// Five fingers around a palm.
struct Star {
  int arms = 5;
  V center{160, 160};
  double distance(const V& p) const {
    double d = 1e9;
    for (int i = 0; i < arms; ++i) {
      const double angle = 0.3 + 2 * std::numbers::pi * i / arms;
      d = std::min(d, Finger{center, {std::cos(angle), std::sin(angle)}}.distance(p));
    }
    return d;
  }
};

TEST(Fingertips, TipsAreFoundAtEveryScaleOfTheHand) {
  CurvatureFinder finder;
  for (const double scale : {0.3, 0.5, 1.0, 2.0}) {
    const Star star;
    DrawnMask drawn = draw(star, scale);
    ASSERT_TRUE(drawn.trace_largest());
    finder.find(drawn.contour, float(kPalmRadius * scale));
    ASSERT_EQ(finder.tips().size(), 5u) << scale;
    for (const Extremum& tip : finder.tips()) {
      const double reach = (tip.at.cast<double>() / scale - star.center).norm();
      EXPECT_NEAR(reach, kReach, 4 + 1 / scale) << scale;
    }
  }
}

TEST(Fingertips, ValleysLieBetweenTheFingersClockwise) {
  const Star star;
  DrawnMask drawn = draw(star);
  ASSERT_TRUE(drawn.trace_largest());
  CurvatureFinder finder;
  finder.find(drawn.contour, kPalmRadius);
  const auto tips = finder.tips();
  ASSERT_EQ(tips.size(), 5u);
  for (std::size_t i = 0; i < 5; ++i) {
    const Extremum &a = tips[i], &b = tips[(i + 1) % 5];
    const V from = a.at.cast<double>() - star.center, to = b.at.cast<double>() - star.center;
    EXPECT_GT(from.x() * to.y() - from.y() * to.x(), 0) << "clockwise on the screen";
    float depth = 0;
    const V valley =
        finder.samples()[finder.valley(a.sample, b.sample, &depth)].cast<double>() - star.center;
    EXPECT_NEAR(valley.norm(), kPalmRadius, 3);
    // On the palm, anywhere between the roots of the two fingers.
    EXPECT_GT(valley.normalized().dot((from + to).normalized()), std::cos(deg(25)));
    EXPECT_NEAR(depth, kReach * std::cos(deg(36)) - kPalmRadius, 6);
  }
}

TEST(Fingertips, ADiscAndAValleyHaveNoTips) {
  CurvatureFinder finder;
  DrawnMask disc(201, 201, [](int u, int v) { return std::hypot(u - 100, v - 100) < 90; });
  ASSERT_TRUE(disc.trace_largest());
  finder.find(disc.contour, 90);
  EXPECT_TRUE(finder.tips().empty());
  // A slot as wide as a finger, cut into a disc: it turns sharply, but inwards.
  DrawnMask slot(201, 201, [](int u, int v) {
    return std::hypot(u - 100, v - 100) < 90 &&
           test::capsule_distance({u, v}, {100, 80}, {100, -40}, 12) > 0;
  });
  ASSERT_TRUE(slot.trace_largest());
  finder.find(slot.contour, 45);
  for (const Extremum& tip : finder.tips()) EXPECT_LT(tip.at.y(), 40) << "only at its rims";
}

/// The axis of a drawn finger whose base is thought to lie `aside` palm radii beside the palm's
/// centre.
struct AxisOfFinger {
  bool measured = false;
  double worst_px = 0;  ///< distance of its places from the true axis
};
AxisOfFinger axis_of(const Finger& finger, double aside, float width) {
  DrawnMask drawn = draw(finger);
  EXPECT_TRUE(drawn.trace_largest());
  CurvatureFinder finder;
  finder.find(drawn.contour, kPalmRadius);
  EXPECT_EQ(finder.tips().size(), 1u);
  const V across(-finger.direction.y(), finger.direction.x());
  const V valley = finger.palm + 60 * finger.direction + 2 * kFingerRadius * across;
  const std::array<Eigen::Vector2f, 1> valleys{valley.cast<float>()};
  const V base = finger.palm + aside * kPalmRadius * across;
  MeasuredAxis axis;
  AxisOfFinger out;
  out.measured = measure_axis(drawn.contour, float(finder.tips()[0].sample) * finder.spacing(),
                              base.cast<float>(), valleys, width, axis);
  for (const Eigen::Vector2f& p : {axis.end, axis.root})
    out.worst_px = std::max(out.worst_px, std::abs((p.cast<double>() - finger.palm).dot(across)));
  return out;
}

TEST(MeasureAxis, IsTheMiddleOfAFingerToAFractionOfAPixel) {
  std::mt19937 rng = test::random_for("MeasureAxis");
  std::uniform_real_distribution<double> between(0, 1);
  for (int degrees = 0; degrees < 360; degrees += 11) {
    const double angle = deg(degrees + between(rng));
    const Finger finger{{160 + between(rng), 160 + between(rng)},
                        {std::cos(angle), std::sin(angle)}};
    for (const double aside : {-0.4, 0.0, 0.4}) {
      const AxisOfFinger axis = axis_of(finger, aside, 2 * kFingerRadius);
      ASSERT_TRUE(axis.measured) << degrees;
      EXPECT_LT(axis.worst_px, 0.4) << degrees << ' ' << aside;
    }
  }
}

TEST(MeasureAxis, IsRefusedWhereSidesAreNoFingers) {
  const Finger finger{{160, 160}, {std::cos(deg(20)), std::sin(deg(20))}};
  EXPECT_FALSE(axis_of(finger, 0, 6 * kFingerRadius).measured) << "too short to tell";
  EXPECT_FALSE(axis_of(finger, 0, 0.8f * kFingerRadius).measured) << "too thick";
  EXPECT_FALSE(axis_of(finger, 3, 2 * kFingerRadius).measured) << "not along the finger";
}

TEST(MeasureValley, IsTheDeepestPointToAFractionOfAPixel) {
  // Two fingers side by side: the gap between them ends in a half circle of radius 7.
  for (const double turn : {0.0, 0.3, 0.8, 1.3}) {
    const Eigen::Rotation2Dd R(turn);
    const V centre(100.3, 100.4), bottom = centre + R * V(0, 7);
    DrawnMask gap(201, 201, [&](int u, int v) {
      const V p(u, v);
      return (p - centre).norm() < 80 &&
             test::capsule_distance(p, centre, centre + R * V(0, -120), 7) > 0;
    });
    ASSERT_TRUE(gap.trace_largest());
    const V left = centre + R * V(-25, -60), right = centre + R * V(25, -60);
    for (const double off : {-2.0, 0.0, 2.0}) {  // along the contour, as coarse samples are
      const Eigen::Vector2f near = (bottom + R * V(off, -1)).cast<float>();
      const Eigen::Vector2f at =
          measure_valley(gap.contour, near, left.cast<float>(), right.cast<float>(), 18);
      EXPECT_LT((at.cast<double>() - bottom).norm(), 1.2) << turn << ' ' << off;
      EXPECT_LT(std::abs((R.inverse() * (at.cast<double>() - bottom)).x()), 1.0) << turn;
    }
  }
}

TEST(MeasureValley, StaysWhereTheBoundaryDoesNotTurnInwards) {
  DrawnMask disc(101, 101, [](int u, int v) { return std::hypot(u - 50, v - 50) < 40; });
  ASSERT_TRUE(disc.trace_largest());
  const Eigen::Vector2f near(50, 90);
  EXPECT_EQ(measure_valley(disc.contour, near, {30, 95}, {70, 95}, 18), near);
}

std::vector<Eigen::Vector2f> on_ellipse(const V& center, double angle, double major, double minor,
                                        double from, double to) {
  std::vector<Eigen::Vector2f> points;
  const Eigen::Rotation2Dd turn(angle);
  for (int i = 0; i <= 40; ++i) {
    const double t = from + (to - from) * i / 40;
    points.push_back((center + turn * V(major * std::cos(t), minor * std::sin(t))).cast<float>());
  }
  return points;
}

TEST(FitEllipse, IsExactOnExactPoints) {
  for (const double angle : {0.0, 0.4, 1.2, 2.5})
    for (const double minor : {5.0, 12.0, 29.0})
      for (const double end : {2.5, 6.2}) {  // an arc; all around
        Ellipse e;
        ASSERT_TRUE(fit_ellipse(on_ellipse({300, 200}, angle, 30, minor, -2.5, end), e));
        EXPECT_NEAR(e.major, 30, 0.05);
        EXPECT_NEAR(e.minor, minor, 0.05);
        EXPECT_LT((e.center - Eigen::Vector2f(300, 200)).norm(), 0.05f);
        const V axis(std::cos(angle), std::sin(angle));
        EXPECT_NEAR(std::abs(axis.dot(e.axis.cast<double>())), 1, 1e-3);
      }
}

TEST(FitEllipse, OfNoisyPointsIsAboutTheSame) {
  std::mt19937 rng = test::random_for("OfNoisyPointsIsAboutTheSame");
  auto points = on_ellipse({50, 60}, 0.7, 30, 15, 0, 6.2);
  for (auto& p : points)
    p += Eigen::Vector2f(float(test::gauss(rng, 0.4)), float(test::gauss(rng, 0.4)));
  Ellipse e;
  ASSERT_TRUE(fit_ellipse(points, e));
  EXPECT_NEAR(e.major, 30, 0.7);
  EXPECT_NEAR(e.minor, 15, 0.7);
  EXPECT_LT((e.center - Eigen::Vector2f(50, 60)).norm(), 0.5f);
}

TEST(FitEllipse, PointsThatFormNoneAreRefused) {
  Ellipse e;
  std::vector<Eigen::Vector2f> line, same(20, {3, 4});
  for (int i = 0; i < 20; ++i) line.push_back({float(i), 2.0f * float(i)});
  EXPECT_FALSE(fit_ellipse(line, e));
  EXPECT_FALSE(fit_ellipse(same, e));
  EXPECT_FALSE(fit_ellipse({}, e));
  const auto few = on_ellipse({0, 0}, 0, 3, 2, 0, 6);
  EXPECT_FALSE(fit_ellipse({few.data(), 5}, e));
}

}  // namespace
}  // namespace handyar
