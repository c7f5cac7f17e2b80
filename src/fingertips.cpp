// SPDX-License-Identifier: MIT
#include "handyar/fingertips.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "vectorised.hpp"

namespace handyar {
namespace {

float cross(const Eigen::Vector2f& a, const Eigen::Vector2f& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Adds `weight` times the cosine between the arms at each of `n` samples, -1 where they turn in.
HANDYAR_VECTORISED void add_convexity(const float* x, const float* y, int n, int arm, float weight,
                                      float* __restrict sum) {
  for (int i = 0; i < n; ++i) {
    const float ax = x[i - arm] - x[i], ay = y[i - arm] - y[i];
    const float bx = x[i + arm] - x[i], by = y[i + arm] - y[i];
    const float cosine =
        (ax * bx + ay * by) / std::sqrt((ax * ax + ay * ay) * (bx * bx + by * by) + 1e-6f);
    // (-a) x b > 0: the contour turns clockwise, outwards.
    sum[i] += weight * (bx * ay - by * ax > 0 ? cosine : -1.0f);
  }
}

}  // namespace

void MaskStages::reserve(int max_pixels, int max_side) {
  constexpr int kMaxContour = 1 << 13;  // points; no hand has more
  region.reserve(max_pixels, max_side);
  contour.reserve(kMaxContour);
}

CurvatureFinder::CurvatureFinder(const FingertipConfig& config)
    : config_(config),
      samples_(kMaxSamples),
      x_(kMaxSamples + 2 * kMaxArm),
      y_(kMaxSamples + 2 * kMaxArm),
      convexity_(kMaxSamples) {}

void CurvatureFinder::find(const Contour& contour, float palm_radius) noexcept {
  constexpr int kScales = 4;
  tip_count_ = 0;
  // Twelve samples a palm radius: about five across a finger's width.
  sample_count_ = contour.resample(std::max(palm_radius / 12, 1.0f), palm_radius / 6, samples_);
  const int n = sample_count_;
  spacing_ = contour.perimeter() / static_cast<float>(n);
  const auto wrap = [n](int i) { return i < 0 ? i + n : i >= n ? i - n : i; };

  const int reach_of_arms = std::max(2, n / 4);
  for (int i = -reach_of_arms; i < n + reach_of_arms; ++i) {
    x_[kMaxArm + i] = samples_[wrap(i)].x();
    y_[kMaxArm + i] = samples_[wrap(i)].y();
  }
  std::fill_n(convexity_.begin(), n, 0.0f);
  for (int s = 0; s < kScales; ++s) {
    const double length = config_.min_arm + (config_.max_arm - config_.min_arm) * s / (kScales - 1);
    const int arm = std::clamp(static_cast<int>(length * palm_radius / spacing_ + 0.5), 2, n / 4);
    add_convexity(x_.data() + kMaxArm, y_.data() + kMaxArm, n, arm, 1.0f / kScales,
                  convexity_.data());
  }
  // Strongest first within half a palm radius along the contour.
  const int reach = std::max(2, static_cast<int>(0.5f * palm_radius / spacing_));
  for (int i = 0; i < n && tip_count_ < kMaxTips; ++i) {
    if (convexity_[i] < config_.min_cosine) continue;
    bool highest = true;
    for (int k = 1; k <= reach && highest; ++k)
      highest = convexity_[i] >= convexity_[wrap(i + k)] && convexity_[i] > convexity_[wrap(i - k)];
    if (!highest) continue;
    // A blunt finger is as sharp at its corners as at its end: take the middle of what is about as
    // sharp (the paper averages likewise).
    int before = 0, after = 0;
    while (before < reach && convexity_[wrap(i - before - 1)] > 0.9f * convexity_[i]) ++before;
    while (after < reach && convexity_[wrap(i + after + 1)] > 0.9f * convexity_[i]) ++after;
    const int middle = wrap(i + (after - before) / 2);
    tips_[tip_count_++] = {middle, samples_[middle], convexity_[i]};
  }
}

int CurvatureFinder::valley(int a, int b, float* depth) const noexcept {
  const int n = sample_count_, length = (b - a + n) % n;
  const Eigen::Vector2f from = samples_[a], along = (samples_[b] - from).normalized();
  int deepest = a;
  float best = -1;
  for (int k = 1; k < length; ++k) {
    const int i = a + k < n ? a + k : a + k - n;
    const float d = cross(along, samples_[i] - from);
    if (d > best) {
      best = d;
      deepest = i;
    }
  }
  *depth = best;
  return deepest;
}

bool fit_ellipse(std::span<const Eigen::Vector2f> points, Ellipse& out) noexcept {
  if (points.size() < 6) return false;
  // Centred and scaled to about unit size, or the quartic sums lose their digits.
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const auto& p : points) mean += p.cast<double>();
  mean /= static_cast<double>(points.size());
  double spread = 0;
  for (const auto& p : points) spread += (p.cast<double>() - mean).squaredNorm();
  const double scale = std::sqrt(spread / static_cast<double>(points.size()));
  if (!(scale > 1e-6)) return false;

  Eigen::Matrix3d S1 = Eigen::Matrix3d::Zero(), S2 = S1, S3 = S1;
  for (const auto& point : points) {
    const Eigen::Vector2d p = (point.cast<double>() - mean) / scale;
    const Eigen::Vector3d quadratic(p.x() * p.x(), p.x() * p.y(), p.y() * p.y());
    const Eigen::Vector3d linear(p.x(), p.y(), 1);
    S1 += quadratic * quadratic.transpose();
    S2 += quadratic * linear.transpose();
    S3 += linear * linear.transpose();
  }
  if (std::abs(S3.determinant()) < 1e-9) return false;
  const Eigen::Matrix3d T = -S3.inverse() * S2.transpose();
  const Eigen::Matrix3d M = S1 + S2 * T;
  // Least q' M q where q' C q = 4ac - b^2 = 1: with M = L L' the largest eigenvector of
  // L^-1 C L^-T. Points that lie on an ellipse exactly make M singular: hence the little more.
  Eigen::Matrix3d C;
  C << 0, 0, 2, 0, -1, 0, 2, 0, 0;
  const Eigen::LLT<Eigen::Matrix3d> cholesky(M + 1e-12 * M.trace() * Eigen::Matrix3d::Identity());
  const Eigen::Matrix3d half = cholesky.matrixL().solve(C);
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(cholesky.matrixL().solve(half.transpose()));
  if (!(solver.eigenvalues()[2] > 0)) return false;
  const Eigen::Vector3d q = cholesky.matrixU().solve(solver.eigenvectors().col(2)).normalized();
  const Eigen::Vector3d l = T * q;
  Eigen::Matrix2d A;
  A << q[0], q[1] / 2, q[1] / 2, q[2];
  const Eigen::Vector2d center = -0.5 * A.inverse() * l.head<2>();
  const double value = center.dot(A * center) - l[2];  // x' A x = value around the centre
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes;
  axes.computeDirect(A);
  const Eigen::Vector2d squares = value * axes.eigenvalues().cwiseInverse();
  if (!(squares.minCoeff() > 0)) return false;
  const int major = squares[0] > squares[1] ? 0 : 1;
  out.center = (center * scale + mean).cast<float>();
  out.axis = axes.eigenvectors().col(major).cast<float>();
  out.major = static_cast<float>(std::sqrt(squares[major]) * scale);
  out.minor = static_cast<float>(std::sqrt(squares[1 - major]) * scale);
  return std::isfinite(out.major) && std::isfinite(out.minor);
}

Eigen::Vector2f Ellipse::end_away_from(const Eigen::Vector2f& base) const noexcept {
  constexpr float kFinger = 2;
  const Eigen::Vector2f finger = (center - base).normalized();
  const Eigen::Matrix2f along = axis * axis.transpose();
  const float round = minor * minor / (major * major);
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2f> directions;
  directions.computeDirect((1 - round) * along +
                           kFinger * round * round * finger * finger.transpose());
  const Eigen::Vector2f direction = directions.eigenvectors().col(1);
  const float cosine2 = direction.dot(axis) * direction.dot(axis);
  const float radius = minor / std::sqrt(cosine2 * round + 1 - cosine2);
  return center + (direction.dot(finger) < 0 ? -radius : radius) * direction;
}

bool fit_tip_ellipse(const Contour& contour, float arc, float width, Ellipse& out) noexcept {
  const int tip = contour.index_at(arc), n = contour.size();
  // The end of the finger: a half circle (0.8 widths of boundary each way) and some of its sides.
  const int reach = std::clamp(contour.index_at(arc + 1.5f * width) - tip, -n, n);
  const int half = std::clamp(reach < 0 ? reach + n : reach, 4, std::max(4, n / 8));
  constexpr int kMaxPoints = 256;
  std::array<Eigen::Vector2f, kMaxPoints> points;
  const int stride = std::max(1, (2 * half + 1 + kMaxPoints - 1) / kMaxPoints);
  int count = 0;
  for (int k = -half; k <= half && count < kMaxPoints; k += stride)
    points[count++] = contour[(tip + k + n) % n];
  return fit_ellipse({points.data(), std::size_t(count)}, out);
}

Eigen::Vector2f measure_tip(const Contour& contour, float arc, const Eigen::Vector2f& base,
                            float width, FingertipMethod method) noexcept {
  const Eigen::Vector2f tip = contour[contour.index_at(arc)];
  Ellipse ellipse;
  if (method == FingertipMethod::curvature || !fit_tip_ellipse(contour, arc, width, ellipse))
    return tip;
  const Eigen::Vector2f end = ellipse.end_away_from(base);
  // An ellipse that runs far past the contour was fitted to something else than a fingertip.
  return (end - tip).norm() > 0.75f * width ? tip : end;
}

namespace {

/// A straight line fitted to contour points by least squares: across = offset + slope * along.
struct StraightSide {
  double n = 0, a = 0, w = 0, aa = 0, aw = 0, ww = 0;
  void add(double along, double across) {
    n += 1;
    a += along;
    w += across;
    aa += along * along;
    aw += along * across;
    ww += across * across;
  }
  double slope() const { return (n * aw - a * w) / (n * aa - a * a); }
  double across_at(double along) const { return w / n + slope() * (along - a / n); }
  double rms() const {
    const double explained = slope() * (aw - a * w / n);
    return std::sqrt(std::max(0.0, (ww - w * w / n - explained) / n));
  }
};

/// Contour points from one between `from` and `to` along a finger, going `step` at a time from its
/// tip. False when the contour leaves the finger before.
bool follow_side(const Contour& contour, int tip, int step, const Eigen::Vector2f& along,
                 float from, float to, float width, StraightSide& side) {
  const Eigen::Vector2f start = contour[tip], across(-along.y(), along.x());
  const int n = contour.size();
  for (int k = 0, i = tip; k < n / 2; ++k) {
    const Eigen::Vector2f d = contour[i] - start;
    const float a = d.dot(along), w = d.dot(across);
    if (a > to) return static_cast<float>(side.n) > 0.5f * (to - from);
    if (std::abs(w) > 1.5f * width) return false;
    if (a >= from) side.add(static_cast<double>(a), static_cast<double>(w));
    i += step;
    if (i == n) i = 0;
    if (i < 0) i = n - 1;
  }
  return false;
}

}  // namespace

bool measure_axis(const Contour& contour, float arc, const Eigen::Vector2f& base,
                  std::span<const Eigen::Vector2f> valleys, float width,
                  MeasuredAxis& out) noexcept {
  constexpr auto kFrom = static_cast<float>(kAxisEnd), kTo = static_cast<float>(kAxisRoot);
  constexpr float kRound = 0.6f, kShort = 0.7f;  // of the width: the end, the least length
  constexpr double kRagged = 0.12, kThin = 0.4, kThick = 1.7;  // of the width
  const int tip = contour.index_at(arc);
  const Eigen::Vector2f start = contour[tip];
  Eigen::Vector2f along = (base - start).stableNormalized();
  // The second time along the axis that the first has found: the same part of the finger is
  // measured, wherever its base was thought to be.
  for (int pass = 0; pass < 2; ++pass) {
    float depth = std::numeric_limits<float>::max();
    for (const Eigen::Vector2f& v : valleys) depth = std::min(depth, (v - start).dot(along));
    const float from = std::max(kFrom * depth, kRound * width), to = kTo * depth;
    if (!(to - from > kShort * width)) return false;
    std::array<StraightSide, 2> sides;
    for (int k = 0; k < 2; ++k) {
      if (!follow_side(contour, tip, k == 0 ? 1 : -1, along, from, to, width, sides[k]))
        return false;
      if (sides[k].rms() > kRagged * static_cast<double>(width)) return false;
    }
    const auto at = [&](float a) -> Eigen::Vector2f {
      const double w = 0.5 * (sides[0].across_at(a) + sides[1].across_at(a));
      return start + a * along + static_cast<float>(w) * Eigen::Vector2f(-along.y(), along.x());
    };
    for (const float a : {from, to}) {
      const double wide = std::abs(sides[0].across_at(a) - sides[1].across_at(a)) / width;
      if (!(wide > kThin && wide < kThick)) return false;
    }
    out = {at(from), at(to)};
    along = (out.root - out.end).stableNormalized();
  }
  return true;
}

Eigen::Vector2f measure_valley(const Contour& contour, const Eigen::Vector2f& near,
                               const Eigen::Vector2f& tip, const Eigen::Vector2f& next_tip,
                               float width) noexcept {
  constexpr float kReach = 0.45f;  // of the width; beyond it are the fingers' sides
  const int n = contour.size();
  if (n < 8) return near;
  int nearest = 0;
  float nearest_px = (contour[0] - near).norm();
  const auto compare = [&](int i) {
    const float px = (contour[i] - near).norm();
    if (px < nearest_px) {
      nearest = i;
      nearest_px = px;
    }
    return px - nearest_px;
  };
  for (int i = 0; i < n; i += 16) compare(i);
  // Neighbours lie at most sqrt(2) apart: far from the nearest point there is no nearer one soon.
  for (int i = 0; i < n;) i += 1 + static_cast<int>(compare(i) / std::numbers::sqrt2_v<float>);

  const Eigen::Vector2d along = (next_tip - tip).cast<double>().normalized();
  Eigen::Vector2d inwards(-along.y(), along.x());
  if (inwards.dot((near - tip).cast<double>()) < 0) inwards = -inwards;
  const double reach = kReach * static_cast<double>(width);
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();  // of 1, s, s^2, where s is the arc in reaches
  Eigen::Matrix<double, 3, 2> b = Eigen::Matrix<double, 3, 2>::Zero();  // along, inwards
  const auto add = [&](int i, double arc) {
    const double s = arc / reach;
    const Eigen::Vector3d powers(1, s, s * s);
    const Eigen::Vector2d d = (contour[i] - near).cast<double>();
    A += powers * powers.transpose();
    b += powers * Eigen::RowVector2d(d.dot(along), d.dot(inwards));
  };
  add(nearest, 0);
  for (const int step : {1, n - 1}) {
    double arc = 0;
    for (int i = nearest, k = 0; k < n / 4; ++k) {
      const int next = (i + step) % n;
      arc += static_cast<double>((contour[next] - contour[i]).norm());
      if (arc > reach) break;
      add(next, step == 1 ? arc : -arc);
      i = next;
    }
  }
  const Eigen::Matrix<double, 3, 2> c = A.ldlt().solve(b);
  if (!c.allFinite() || !(c(2, 1) < 0)) return near;
  const double s = -0.5 * c(1, 1) / c(2, 1);
  if (!(std::abs(s) < 1)) return near;
  const Eigen::RowVector2d at = Eigen::RowVector3d(1, s, s * s) * c;
  return near + (at.x() * along + at.y() * inwards).cast<float>();
}

}  // namespace handyar
