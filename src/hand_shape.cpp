// SPDX-License-Identifier: MIT
#include "handyar/hand_shape.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

namespace handyar {
namespace {

// The average hand in the plane, metres, thumb_right: tips, then the valleys between neighbours.
constexpr int kPoints = kFingerCount + kValleyCount;
const Eigen::Matrix<float, 2, kPoints> kHand =
    (Eigen::Matrix<float, 2, kPoints>() <<  //
         0.0935f,
     0.0445f, 0.0f, -0.0400f, -0.0710f, 0.0350f, 0.0115f, -0.0120f, -0.0355f, 0.0f, 0.0780f,
     0.0920f, 0.0770f, 0.0390f, -0.0180f, 0.0150f, 0.0140f, 0.0030f)
        .finished();
// The thumb moves most between people and postures, and its valley with it.
const Eigen::Matrix<float, kPoints, 1> kWeight =
    (Eigen::Matrix<float, kPoints, 1>() << 0.4f, 1, 1, 1, 0.8f, 0.5f, 1, 1, 1).finished();
const Eigen::Vector2f kPalmCenter(-0.002f, -0.035f);
constexpr float kPalmRadius_m = 0.038f;
constexpr float kFingerWidth_m = 0.017f;

Eigen::Vector2f in_layout(Eigen::Vector2f p_hand_m, Layout layout) {
  if (layout == Layout::thumb_left) p_hand_m.x() = -p_hand_m.x();
  return p_hand_m;
}

Eigen::Vector2f hand_point(int i, Layout layout) { return in_layout(kHand.col(i), layout); }

/// Share of a disc's image under the affine map that lies in the mask.
float palm_fill(const HandShape& shape, const Mask& mask) {
  int inside = 0, total = 0;
  for (const float radius : {0.3f, 0.65f, 0.9f})
    for (int k = 0; k < 12; ++k, ++total) {
      const float angle = 0.5236f * static_cast<float>(k);
      const Eigen::Vector2f offset(std::cos(angle), std::sin(angle));
      const Eigen::Vector2f at =
          shape.to_image(in_layout(kPalmCenter, shape.layout) + radius * kPalmRadius_m * offset);
      const int u = static_cast<int>(std::lround(at.x())),
                v = static_cast<int>(std::lround(at.y()));
      inside += u >= 0 && v >= 0 && u < mask.width && v < mask.height && mask.at(u, v);
    }
  return static_cast<float>(inside) / static_cast<float>(total);
}

/// Share of stations along a finger at which the region is about as wide as a finger; of the five
/// fingers the least.
float finger_fill(const HandShape& shape, const Mask& mask) {
  const auto inside = [&](const Eigen::Vector2f& p) {
    const int u = static_cast<int>(std::lround(p.x())), v = static_cast<int>(std::lround(p.y()));
    return u >= 0 && v >= 0 && u < mask.width && v < mask.height && mask.at(u, v);
  };
  const float widest = 1.8f * shape.finger_width, narrowest = 0.4f * shape.finger_width;
  int least = std::numeric_limits<int>::max();
  constexpr std::array<float, 5> kStations = {0.4f, 0.5f, 0.6f, 0.7f, 0.8f};
  for (int f = 0; f < kFingerCount; ++f) {
    if (!shape.tip_seen[f]) continue;
    const Eigen::Vector2f from = shape.finger_base(f), along = shape.tips[f] - from;
    const Eigen::Vector2f across = Eigen::Vector2f(-along.y(), along.x()).normalized();
    int good = 0;
    for (const float s : kStations) {
      // The tip and the base are a little off the axis: look for the finger around it.
      Eigen::Vector2f at = from + s * along;
      for (const float shift : {0.25f, -0.25f, 0.5f, -0.5f}) {
        if (inside(at)) break;
        at = from + s * along + shift * shape.finger_width * across;
      }
      if (!inside(at)) continue;
      float left = 0, right = 0;
      while (left < widest && inside(at + (left + 1) * across)) ++left;
      while (right < widest && inside(at - (right + 1) * across)) ++right;
      const float width = left + right + 1;
      good += width > narrowest && width < widest;
    }
    least = std::min(least, good);
  }
  return static_cast<float>(least) / static_cast<float>(kStations.size());
}

/// Length of the boundary from the first to the last tip over its smoothed length: near one for a
/// clean outline, large for noise.
float raggedness(const HandShape& shape, const CurvatureFinder& curvature, const Contour& contour) {
  const int n = static_cast<int>(curvature.samples().size());
  int a = shape.tip_samples[0], b = shape.tip_samples[4];
  if (shape.layout == Layout::thumb_right) std::swap(a, b);  // clockwise from a to b
  const int count = (b - a + n) % n;
  float smooth = 0;
  for (int k = 0; k < count; ++k)
    smooth += (curvature.samples()[(a + k + 1) % n] - curvature.samples()[(a + k) % n]).norm();
  const float raw = contour.perimeter() * static_cast<float>(count) / static_cast<float>(n);
  return raw / std::max(smooth, 1.0f);
}

}  // namespace

Eigen::Vector2f HandShape::palm() const noexcept {
  return to_image(in_layout(kPalmCenter, layout));
}

float HandShape::palm_radius() const noexcept {
  return finger_width * (kPalmRadius_m / kFingerWidth_m);
}

Eigen::Vector2f HandShape::finger_base(int finger) const noexcept {
  if (finger == int(Finger::thumb))
    return valleys[0] + image_hand.leftCols<2>() * in_layout({0.008f, -0.010f}, layout);
  if (finger == int(Finger::little)) return valleys[3] + 0.5f * (valleys[3] - valleys[2]);
  return 0.5f * (valleys[finger - 1] + valleys[finger]);
}

Eigen::AlignedBox2f HandShape::bounds() const noexcept {
  Eigen::AlignedBox2f box(palm());
  for (int f = 0; f < kFingerCount; ++f) box.extend(tips[f]);
  for (const Eigen::Vector2f& p : {Eigen::Vector2f(-0.045f, -0.085f), {0.045f, -0.085f}})
    box.extend(to_image(p));
  for (int i = 0; i < kPoints; ++i) box.extend(to_image(hand_point(i, layout)));
  return box;
}

bool HandShape::may_hold(const Eigen::Vector2f& p) const noexcept {
  const Eigen::Matrix2f linear = image_hand.leftCols<2>();
  const float det = linear(0, 0) * linear(1, 1) - linear(0, 1) * linear(1, 0);
  const Eigen::Vector2f d = p - image_hand.col(2);
  const Eigen::Vector2f p_hand_m((linear(1, 1) * d.x() - linear(0, 1) * d.y()) / det,
                                 (linear(0, 0) * d.y() - linear(1, 0) * d.x()) / det);
  constexpr float kForearmTop_m = -0.04f, kForearmHalfWidth_m = 0.075f;
  if (p_hand_m.y() < kForearmTop_m && std::abs(p_hand_m.x()) < kForearmHalfWidth_m) return true;
  const float palm_reach_m = 1.45f * kPalmRadius_m;
  if ((p_hand_m - in_layout(kPalmCenter, layout)).squaredNorm() < palm_reach_m * palm_reach_m)
    return true;
  for (int f = 0; f < kFingerCount; ++f) {
    const Eigen::Vector2f from = finger_base(f), along = tips[f] - from;
    const float s = std::clamp((p - from).dot(along) / along.squaredNorm(), 0.0f, 1.0f);
    if ((p - from - s * along).squaredNorm() < finger_width * finger_width) return true;
  }
  return false;
}

bool HandShape::resembles(const HandShape& other) const noexcept {
  if (layout != other.layout) return false;
  const float limit = 0.2f * (other.tips[0] - other.tips[4]).norm();
  for (int f = 0; f < kFingerCount; ++f)
    if ((tips[f] - other.tips[f]).norm() > limit) return false;
  return true;
}

HandShape HandShape::transformed(float scale, const Eigen::Vector2f& offset) const noexcept {
  HandShape s = *this;
  for (auto& p : s.tips) p = scale * p + offset;
  for (auto& p : s.valleys) p = scale * p + offset;
  s.image_hand *= scale;
  s.image_hand.col(2) += offset;
  s.finger_width *= scale;
  return s;
}

bool fit_hand_shape(const HandShapeConfig& config, HandShape& shape) noexcept {
  Eigen::Matrix3f A = Eigen::Matrix3f::Zero();
  Eigen::Matrix<float, 3, 2> B = Eigen::Matrix<float, 3, 2>::Zero();
  const auto seen = [&](int i) {
    return i < kFingerCount ? shape.tip_seen[i] : shape.valley_seen[i - kFingerCount];
  };
  const auto image_point = [&](int i) {
    return i < kFingerCount ? shape.tips[i] : shape.valleys[i - kFingerCount];
  };
  for (int i = 0; i < kPoints; ++i) {
    if (!seen(i)) continue;
    const Eigen::Vector2f at = hand_point(i, shape.layout);
    const Eigen::Vector3f p(at.x(), at.y(), 1);
    A += kWeight[i] * p * p.transpose();
    B += kWeight[i] * p * image_point(i).transpose();
  }
  // Metres are small numbers: scale the plane's axes so that the normal equations stay well posed.
  const Eigen::Vector3f scale(20, 20, 1);
  const Eigen::Matrix3f scaled = scale.asDiagonal() * A * scale.asDiagonal();
  shape.image_hand = (scale.asDiagonal() * scaled.ldlt().solve(scale.asDiagonal() * B)).transpose();

  float sum = 0, weight = 0;
  for (int i = 0; i < kPoints; ++i) {
    if (!seen(i)) continue;
    sum +=
        kWeight[i] * (shape.to_image(hand_point(i, shape.layout)) - image_point(i)).squaredNorm();
    weight += kWeight[i];
  }
  const float a = shape.image_hand(0, 0), b = shape.image_hand(0, 1);
  const float c = shape.image_hand(1, 0), d = shape.image_hand(1, 1);
  const float trace = a * a + b * b + c * c + d * d, det = a * d - b * c;
  const float root = std::sqrt(std::max(trace * trace - 4 * det * det, 0.0f));
  const float larger = std::sqrt(0.5f * (trace + root));
  const float smaller = std::sqrt(std::max(0.5f * (trace - root), 0.0f));
  const float span = larger * 0.17f;
  shape.residual = std::sqrt(sum / weight) / std::max(span, 1e-3f);
  shape.finger_width = kFingerWidth_m * std::sqrt(larger * smaller);
  // y points up on the hand and down in the image: the map must turn orientation over.
  return det < 0 && smaller > config.min_aspect * larger && shape.residual < config.max_residual;
}

bool fills_region(const HandShape& shape, const Mask& mask,
                  const HandShapeConfig& config) noexcept {
  return palm_fill(shape, mask) >= config.min_palm_fill &&
         finger_fill(shape, mask) >= config.min_finger_fill;
}

bool find_hand_shape(const CurvatureFinder& curvature, const Contour& contour, const Mask& mask,
                     float palm_radius, const HandShapeConfig& config, HandShape& best) noexcept {
  const auto tips = curvature.tips();
  const auto samples = curvature.samples();
  const int n = static_cast<int>(tips.size());
  if (n < kFingerCount) return false;

  // Which tips can be neighbouring fingers: valley[i][j] clockwise from i to j, or -1.
  constexpr int kMax = CurvatureFinder::kMaxTips;
  std::array<std::array<int, kMax>, kMax> valley;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      valley[i][j] = -1;
      if (i == j) continue;
      const float distance = (tips[i].at - tips[j].at).norm();
      if (distance > 5 * palm_radius) continue;
      float depth = 0;
      const int at = curvature.valley(tips[i].sample, tips[j].sample, &depth);
      if (depth > config.min_valley_depth * palm_radius && depth < 4.5f * palm_radius)
        valley[i][j] = at;
    }

  best.residual = static_cast<float>(config.max_residual);
  bool found = false;
  const auto consider = [&](const std::array<int, kFingerCount>& clockwise) {
    for (const Layout layout : {Layout::thumb_right, Layout::thumb_left}) {
      HandShape shape;
      shape.layout = layout;
      shape.tip_seen.fill(true);
      shape.valley_seen.fill(true);
      // Clockwise with the thumb on the right: little finger first.
      const bool reversed = layout == Layout::thumb_right;
      for (int f = 0; f < kFingerCount; ++f) {
        const int tip = clockwise[reversed ? kFingerCount - 1 - f : f];
        shape.tip_samples[f] = tips[tip].sample;
        shape.tips[f] = tips[tip].at;
      }
      for (int k = 0; k < kValleyCount; ++k) {
        const int gap = reversed ? kValleyCount - 1 - k : k;
        shape.valleys[k] = samples[valley[clockwise[gap]][clockwise[gap + 1]]];
      }
      if (!fit_hand_shape(config, shape)) continue;
      if (shape.residual >= best.residual || !fills_region(shape, mask, config) ||
          raggedness(shape, curvature, contour) > config.max_raggedness)
        continue;
      best = shape;
      found = true;
    }
  };
  // All chains of five in clockwise order; the contour is closed, so each tip may begin one.
  std::array<int, kFingerCount> chain;
  const auto extend = [&](auto&& self, int length, int turned) -> void {
    if (length == kFingerCount) return consider(chain);
    for (int step = 1; turned + step < n; ++step) {
      const int next = (chain[length - 1] + step) % n;
      if (valley[chain[length - 1]][next] < 0) continue;
      chain[length] = next;
      self(self, length + 1, turned + step);
    }
  };
  for (int first = 0; first < n; ++first) {
    chain[0] = first;
    extend(extend, 1, 0);
  }
  return found;
}

}  // namespace handyar
