// SPDX-License-Identifier: MIT
#include "handyar/contour.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <set>

#include "drawn_mask.hpp"
#include "synthetic_hand.hpp"

namespace handyar {
namespace {

using std::numbers::pi;
using test::DrawnMask;

/// Twice the enclosed area; positive: clockwise on the screen (y down).
double signed_area(const Contour& c) {
  double sum = 0;
  for (int i = 0; i < c.size(); ++i) {
    const Eigen::Vector2f p = c[i], q = c[(i + 1) % c.size()];
    sum += double(p.x()) * q.y() - double(q.x()) * p.y();
  }
  return sum / 2;
}

std::set<std::pair<int, int>> points_of(const Contour& c) {
  std::set<std::pair<int, int>> points;
  for (int i = 0; i < c.size(); ++i) points.insert({int(c[i].x()), int(c[i].y())});
  return points;
}

/// Pixels of the component that touch the outside, reached from the border of the picture, by an
/// edge.
std::set<std::pair<int, int>> outer_boundary(const Mask& mask) {
  const int w = mask.width + 2, h = mask.height + 2;
  std::vector<char> outside(w * h, 0);
  std::vector<std::pair<int, int>> open = {{-1, -1}};
  std::set<std::pair<int, int>> boundary;
  outside[0] = 1;
  while (!open.empty()) {
    const auto [u, v] = open.back();
    open.pop_back();
    for (const auto& [du, dv] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      const int x = u + du, y = v + dv;
      if (x < -1 || y < -1 || x > mask.width || y > mask.height) continue;
      if (x >= 0 && y >= 0 && x < mask.width && y < mask.height && mask.at(x, y)) {
        boundary.insert({x, y});
      } else if (!outside[(y + 1) * w + x + 1]) {
        outside[(y + 1) * w + x + 1] = 1;
        open.push_back({x, y});
      }
    }
  }
  return boundary;
}

void expect_closed(const Contour& c) {
  for (int i = 0; i < c.size(); ++i) {
    const Eigen::Vector2f step = c[(i + 1) % c.size()] - c[i];
    ASSERT_EQ(step.cwiseAbs().maxCoeff(), 1) << "point " << i;
    ASSERT_NEAR(c.arc_length(i + 1) - c.arc_length(i), step.norm(), 1e-3) << "point " << i;
  }
}

TEST(Contour, ASquare) {
  DrawnMask square(50, 40, [](int u, int v) { return u >= 10 && u < 31 && v >= 5 && v < 26; });
  ASSERT_TRUE(square.trace_largest());
  EXPECT_EQ(square.contour.size(), 80);
  EXPECT_FLOAT_EQ(square.contour.perimeter(), 80);
  EXPECT_DOUBLE_EQ(signed_area(square.contour), 400);  // between pixel centres
  EXPECT_EQ(square.contour[0], Eigen::Vector2f(10, 5));
  expect_closed(square.contour);
}

TEST(Contour, ADiscAtTheBordersOfTheMask) {
  for (const double radius : {5.0, 40.0, 150.0}) {
    const int size = static_cast<int>(2 * radius) + 1;
    DrawnMask disc(size, size,
                   [&](int u, int v) { return std::hypot(u - radius, v - radius) <= radius; });
    ASSERT_TRUE(disc.trace_largest());
    expect_closed(disc.contour);
    EXPECT_NEAR(signed_area(disc.contour), pi * radius * radius, 2.5 * pi * radius);
    // Stairs are longer than the circle, by at most 8 %.
    EXPECT_GT(disc.contour.perimeter(), 0.97 * 2 * pi * (radius - 0.5));
    EXPECT_LT(disc.contour.perimeter(), 1.09 * 2 * pi * radius);
  }
}

TEST(Contour, ASpurOnePixelWideIsFollowedOutAndBack) {
  DrawnMask spur(60, 40, [](int u, int v) {
    return (u >= 10 && u < 21 && v >= 10 && v < 21) || (v == 15 && u > 20 && u < 50) ||
           (u == 15 && v < 10);
  });
  ASSERT_TRUE(spur.trace_largest());
  expect_closed(spur.contour);
  // Diagonal steps cut the four corners where the spurs begin.
  EXPECT_DOUBLE_EQ(signed_area(spur.contour), 100 + 4 * 0.5);
  EXPECT_NEAR(spur.contour.perimeter(), 40 + 2 * 29 + 2 * 10 - 4 * (2 - std::sqrt(2)), 1e-3);
}

TEST(Contour, HolesAreNotFollowed) {
  DrawnMask ring(60, 60, [](int u, int v) {
    const double d = std::hypot(u - 30, v - 30);
    return d < 25 && d > 10;
  });
  ASSERT_TRUE(ring.trace_largest());
  for (int i = 0; i < ring.contour.size(); ++i)
    EXPECT_GT((ring.contour[i] - Eigen::Vector2f(30, 30)).norm(), 23);
}

TEST(Contour, OfRandomBlobsExactlyTheOuterBoundary) {
  std::mt19937 rng = test::random_for("OfRandomBlobsExactlyTheOuterBoundary");
  for (int trial = 0; trial < 40; ++trial) {
    DrawnMask blob(40, 30, [&](int u, int v) {
      return std::hypot(u - 20, v - 15) < 6 || int(rng() % 100) < 20 + trial;
    });
    const auto components = blob.region.components(1);
    ASSERT_FALSE(components.empty());
    blob.largest = components[0];
    blob.region.keep_only(blob.largest);
    ASSERT_TRUE(blob.contour.trace(blob.region.mask(), blob.largest));
    expect_closed(blob.contour);
    EXPECT_GT(signed_area(blob.contour), 0);
    EXPECT_EQ(points_of(blob.contour), outer_boundary(blob.region.mask())) << "trial " << trial;
  }
}

TEST(Contour, NothingToFollow) {
  DrawnMask dot(20, 20, [](int u, int v) { return u == 7 && v == 9; });
  EXPECT_FALSE(dot.trace_largest());
  DrawnMask long_way(200, 200, [](int, int) { return true; });
  long_way.contour.reserve(100);
  EXPECT_FALSE(long_way.trace_largest());
  DrawnMask empty(20, 20, [](int, int) { return false; });
  EXPECT_FALSE(empty.contour.trace(empty.region.mask()));
  EXPECT_EQ(empty.contour.size(), 0);
}

TEST(Contour, OfASingleComponentWithoutBeingToldWhichOne) {
  DrawnMask disc(90, 80, [](int u, int v) { return std::hypot(u - 44, v - 44) < 30; });
  ASSERT_TRUE(disc.trace_largest());
  const auto told = points_of(disc.contour);
  ASSERT_TRUE(disc.contour.trace(disc.region.mask()));
  EXPECT_EQ(points_of(disc.contour), told);
}

TEST(Contour, IndexAtIsTheInverseOfArcLengthAndWrapsAround) {
  DrawnMask disc(90, 90, [](int u, int v) { return std::hypot(u - 44, v - 44) < 40; });
  ASSERT_TRUE(disc.trace_largest());
  const Contour& c = disc.contour;
  for (int i = 0; i < c.size(); ++i) {
    const float middle = 0.5f * (c.arc_length(i) + c.arc_length(i + 1));
    for (const int turns : {-1, 0, 1})
      ASSERT_EQ(c.index_at(middle + float(turns) * c.perimeter()), i);
  }
}

TEST(Contour, ResampledPointsAreEvenlySpacedAndSmooth) {
  constexpr double kRadius = 60;
  DrawnMask disc(130, 130, [](int u, int v) { return std::hypot(u - 64, v - 64) < kRadius; });
  ASSERT_TRUE(disc.trace_largest());
  std::array<Eigen::Vector2f, 256> out;
  const int n = disc.contour.resample(5, 8, out);
  EXPECT_NEAR(n, disc.contour.perimeter() / 5, 1);
  const double step = 2 * pi * kRadius / n;
  for (int i = 0; i < n; ++i) {
    EXPECT_NEAR((out[(i + 1) % n] - out[i]).norm(), step, 0.12 * step) << i;
    EXPECT_NEAR((out[i] - Eigen::Vector2f(64, 64)).norm(), kRadius - 0.5, 0.8) << i;
  }
  // Too little room: the same contour, coarser.
  const int few = disc.contour.resample(1, 8, {out.data(), 50});
  EXPECT_EQ(few, 50);
  EXPECT_NEAR((out[1] - out[0]).norm(), 2 * pi * kRadius / 50, 1);
}

TEST(Contour, OfTheMirroredMaskIsTheMirroredContour) {
  const auto inside = [](int u, int v) {
    return std::hypot(u - 40, v - 50) < 30 ||
           test::capsule_distance({u, v}, {40, 50}, {90, 12}, 6) < 0;
  };
  DrawnMask one(101, 90, inside), other(101, 90, [&](int u, int v) { return inside(100 - u, v); });
  ASSERT_TRUE(one.trace_largest());
  ASSERT_TRUE(other.trace_largest());
  std::set<std::pair<int, int>> mirrored;
  for (const auto& [u, v] : points_of(other.contour)) mirrored.insert({100 - u, v});
  EXPECT_EQ(points_of(one.contour), mirrored);
  EXPECT_NEAR(one.contour.perimeter(), other.contour.perimeter(), 1e-2);
  EXPECT_DOUBLE_EQ(signed_area(one.contour), signed_area(other.contour));
}

}  // namespace
}  // namespace handyar
