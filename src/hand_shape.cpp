// SPDX-License-Identifier: MIT
#include "handyar/hand_shape.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace handyar {
namespace {

constexpr int kPoints = kFingerCount + kValleyCount;

#include "hand_shape_statistics.inc"

const Eigen::Vector2f kPalmCenter(-0.002f, -0.035f);
constexpr float kPalmRadius_m = 0.038f;
constexpr float kFingerWidth_m = 0.017f;

Eigen::Vector2f in_layout(Eigen::Vector2f p_hand_m, Layout layout) {
  if (layout == Layout::thumb_left) p_hand_m.x() = -p_hand_m.x();
  return p_hand_m;
}

Eigen::Vector2f hand_point(int i, Layout layout) {
  return in_layout(kMean_mm.col(i) / 1000, layout);
}

/// Tips, then valleys.
Eigen::Matrix<float, 2, kPoints> points_of(const HandShape& shape) {
  Eigen::Matrix<float, 2, kPoints> points;
  for (int f = 0; f < kFingerCount; ++f) points.col(f) = shape.tips[f];
  for (int k = 0; k < kValleyCount; ++k) points.col(kFingerCount + k) = shape.valleys[k];
  return points;
}

/// Share of a disc's image under the affine map that lies in the mask.
float palm_fill(const HandShape& shape, const Mask& mask) {
  int inside = 0, total = 0;
  for (const float radius : {0.3f, 0.65f, 0.9f})
    for (int k = 0; k < 12; ++k, ++total) {
      const float angle = 0.5236f * static_cast<float>(k);
      const Eigen::Vector2f offset(std::cos(angle), std::sin(angle));
      inside += mask.holds(
          shape.to_image(in_layout(kPalmCenter, shape.layout) + radius * kPalmRadius_m * offset));
    }
  return static_cast<float>(inside) / static_cast<float>(total);
}

/// Share of stations along a finger at which the region is about as wide as a finger; of the five
/// fingers the least.
float finger_fill(const HandShape& shape, const Mask& mask) {
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
        if (mask.holds(at)) break;
        at = from + s * along + shift * shape.finger_width * across;
      }
      if (!mask.holds(at)) continue;
      float left = 0, right = 0;
      while (left < widest && mask.holds(at + (left + 1) * across)) ++left;
      while (right < widest && mask.holds(at - (right + 1) * across)) ++right;
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

HandReach::HandReach(const HandShape& shape) noexcept
    : palm_m_(in_layout(kPalmCenter, shape.layout)),
      finger_width2_(shape.finger_width * shape.finger_width) {
  const Eigen::Matrix2f linear = shape.image_hand.leftCols<2>().inverse();
  hand_image_ << linear, -linear * shape.image_hand.col(2);
  for (int f = 0; f < kFingerCount; ++f) {
    const Eigen::Vector2f base = shape.finger_base(f);
    fingers_[f] = {base, shape.tips[f] - base};
  }
}

bool HandReach::holds(const Eigen::Vector2f& p) const noexcept {
  constexpr float kForearmTop_m = -0.04f, kForearmHalfWidth_m = 0.075f;
  constexpr float kPalmReach_m = 1.45f * kPalmRadius_m;
  const Eigen::Vector2f p_m = hand_image_.leftCols<2>() * p + hand_image_.col(2);
  if (p_m.y() < kForearmTop_m && std::abs(p_m.x()) < kForearmHalfWidth_m) return true;
  if ((p_m - palm_m_).squaredNorm() < kPalmReach_m * kPalmReach_m) return true;
  return std::ranges::any_of(fingers_, [&](const HandAxis& finger) {
    return finger.offset(p).squaredNorm() < finger_width2_;
  });
}

ExpectedHand HandShape::parts() const noexcept {
  ExpectedHand hand{palm(), finger_width, {}};
  for (int f = 1; f < kFingerCount; ++f) hand.fingers[f - 1] = {finger_base(f), tips[f]};
  return hand;
}

void HandShape::expect(int width, int height, ExpectedRegion& region) const noexcept {
  struct Capsule {
    HandAxis axis;
    float radius;
  };
  std::array<Capsule, kFingerCount + 2> parts;
  for (int f = 0; f < kFingerCount; ++f) {
    const Eigen::Vector2f from = finger_base(f), to = tips[f];
    const float length = std::max((to - from).norm(), finger_width);
    parts[f] = {{from, (1 - 0.5f * finger_width / length) * (to - from)}, 0.5f * finger_width};
  }
  parts[kFingerCount] = {HandAxis(palm()), 1.05f * palm_radius()};
  // The ball of the thumb, from the wrist on.
  const Eigen::Vector2f up = image_hand.col(1).normalized(), right(-up.y(), up.x());
  const Eigen::Vector2f wrist = palm() - palm_radius() * up;
  parts[kFingerCount + 1] = {{wrist, finger_base(0) - wrist}, 0.8f * finger_width};
  const Eigen::Vector2f palm_center = palm();
  const float forearm = 1.6f * palm_radius();

  region.cell = std::max(2, static_cast<int>(finger_width / 4));
  region.columns = (width + region.cell - 1) / region.cell;
  std::int8_t* to = region.ratios.data();
  for (int v = 0; v < height; v += region.cell)
    for (int u = 0; u < width; u += region.cell, ++to) {
      const Eigen::Vector2f p = Eigen::Vector2f(float(u), float(v)).array() + 0.5f * region.cell;
      float distance = std::numeric_limits<float>::max();
      for (const Capsule& part : parts) {
        const float away2 = part.axis.offset(p).squaredNorm(), nearer = distance + part.radius;
        if (nearer > 0 && away2 < nearer * nearer) distance = std::sqrt(away2) - part.radius;
      }
      const float fingers = distance / finger_width;
      const Eigen::Vector2f below = p - palm_center;
      if (fingers < -0.1f) {
        *to = ExpectedRegion::kInside;
      } else if (fingers < 0.5f || (below.dot(up) < 0 && std::abs(below.dot(right)) < forearm)) {
        *to = 0;  // the border may be here, or the forearm: the picture decides
      } else {
        *to = static_cast<std::int8_t>(
            std::max(-40 * (fingers - 0.5f), float(ExpectedRegion::kOutside)));
      }
    }
}

bool HandShape::resembles(const HandShape& other) const noexcept {
  if (layout != other.layout) return false;
  const float limit = 0.2f * (other.tips[0] - other.tips[4]).norm();
  for (int f = 0; f < kFingerCount; ++f)
    if ((tips[f] - other.tips[f]).norm() > limit) return false;
  return true;
}

bool HandShape::may_follow(const HandShape& last) const noexcept {
  constexpr float kGrowth = 1.3f, kReach = 4;  // palm radii
  return layout == last.layout && finger_width < kGrowth * last.finger_width &&
         last.finger_width < kGrowth * finger_width &&
         (palm() - last.palm()).norm() < kReach * last.palm_radius();
}

Eigen::Matrix<float, 2, 3> HandShape::image_thumb_right() const noexcept {
  Eigen::Matrix<float, 2, 3> map = image_hand;
  if (layout == Layout::thumb_left) map.col(0) *= -1;
  return map;
}

HandShape HandShape::in_hand_plane() const noexcept {
  const Eigen::Matrix<float, 2, 3> map = image_thumb_right();
  const Eigen::Matrix2f inverse = map.leftCols<2>().inverse();
  HandShape hand = average_hand_shape();
  for (int f = 0; f < kFingerCount; ++f) hand.tips[f] = inverse * (tips[f] - map.col(2));
  for (int k = 0; k < kValleyCount; ++k) hand.valleys[k] = inverse * (valleys[k] - map.col(2));
  return hand;
}

HandShape HandShape::laid(const Eigen::Matrix<float, 2, 3>& image_thumb_right,
                          Layout image_layout) const noexcept {
  HandShape s = *this;
  s.layout = image_layout;
  for (auto& p : s.tips) p = image_thumb_right * p.homogeneous();
  for (auto& p : s.valleys) p = image_thumb_right * p.homogeneous();
  s.image_hand = image_thumb_right;
  if (image_layout == Layout::thumb_left) s.image_hand.col(0) *= -1;
  s.finger_width =
      kFingerWidth_m * std::sqrt(std::abs(image_thumb_right.leftCols<2>().determinant()));
  return s;
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

HandShape average_hand_shape() noexcept {
  HandShape hand;
  for (int f = 0; f < kFingerCount; ++f) hand.tips[f] = hand_point(f, Layout::thumb_right);
  for (int k = 0; k < kValleyCount; ++k)
    hand.valleys[k] = hand_point(kFingerCount + k, Layout::thumb_right);
  hand.tip_seen.fill(true);
  hand.valley_seen.fill(true);
  hand.image_hand << 1, 0, 0, 0, 1, 0;
  hand.finger_width = kFingerWidth_m;
  return hand;
}

Eigen::Matrix<double, 3, kValleyCount> average_valleys_m(const HandModel& hand) noexcept {
  Eigen::Matrix<double, 3, kPoints> average_mm = Eigen::Matrix<double, 3, kPoints>::Ones();
  for (int i = 0; i < kPoints; ++i)
    average_mm.col(i).head<2>() = hand_point(i, hand.layout).cast<double>() * 1000;
  const auto tips_mm = average_mm.leftCols<kFingerCount>();
  const Eigen::Matrix<double, 2, 3> hand_average =
      hand.tips_m.topRows<2>() * tips_mm.transpose() * (tips_mm * tips_mm.transpose()).inverse();
  Eigen::Matrix<double, 3, kValleyCount> valleys_m = Eigen::Matrix<double, 3, kValleyCount>::Zero();
  valleys_m.topRows<2>() = hand_average * average_mm.rightCols<kValleyCount>();
  return valleys_m;
}

HandShapeModel::HandShapeModel() { set_mean(kMean_mm.cast<double>() / 1000); }

HandShapeModel::HandShapeModel(const HandModel& hand, const HandShapeConfig& config)
    : HandShapeModel() {
  if (!hand.has_valleys) return;
  strictness_ = static_cast<float>(1 / config.posture_share);
  const HandModel right = hand.for_layout(Layout::thumb_right);
  Eigen::Matrix<double, 2, kPoints> mean_m;
  mean_m << right.tips_m.topRows<2>(), right.valleys_m.topRows<2>();
  set_mean(mean_m);
}

void HandShapeModel::set_mean(const Eigen::Matrix<double, 2, kPoints>& mean_m) {
  Eigen::Matrix<double, kPoints, 3> A;
  A << mean_m.transpose(), Eigen::Matrix<double, kPoints, 1>::Ones();
  mean_ = A.transpose().cast<float>();
  fit_ = (A * (A.transpose() * A).inverse()).cast<float>();
}

bool HandShapeModel::fit(const HandShapeConfig& config, HandShape& shape) const noexcept {
  const Eigen::Matrix<float, 2, kPoints> points = points_of(shape);
  // The mean is a thumb_right hand: fit it, and mirror the map for the other layout.
  const Eigen::Matrix<float, 2, 3> map = points * fit_;
  const Eigen::Matrix2f linear = map.leftCols<2>();
  const float det = linear.determinant(), norm = linear.squaredNorm();
  const float root = std::sqrt(std::max(norm * norm - 4 * det * det, 0.0f));
  const float larger = std::sqrt(0.5f * (norm + root));
  const float smaller = std::sqrt(std::max(0.5f * (norm - root), 0.0f));
  shape.finger_width = kFingerWidth_m * std::sqrt(larger * smaller);
  const bool right = shape.layout == Layout::thumb_right;
  shape.image_hand = map;
  if (!right) shape.image_hand.col(0) *= -1;
  // y points up on the hand and down in the image: the map turns orientation over.
  const bool faces_us = right ? det < 0 : det > 0;
  shape.deviation = std::numeric_limits<float>::max();
  if (!faces_us || smaller <= config.min_aspect * larger) return false;
  // What the map leaves, in millimetres of a hand seen from the front, y along the fingers, x to
  // the thumb: against how hands vary.
  Eigen::Matrix2f axes;  // rows: the hand's x and y direction in the image
  axes.row(1) = linear.col(1).normalized().transpose();
  axes.row(0) = Eigen::RowVector2f(-axes(1, 1), axes(1, 0));
  if (!right) axes.row(0) = -axes.row(0);
  const Eigen::Matrix<float, 2, kPoints> rest = (1000 / larger) * axes * (points - map * mean_);
  const Eigen::Map<const Eigen::Matrix<float, 2 * kPoints, 1>> flat(rest.data());
  Eigen::Matrix<float, 12, 1> deviations = Eigen::Matrix<float, 12, 1>::Zero();
  for (int i = 0; i < 2 * kPoints; ++i) deviations += kWhitening.col(i) * flat[i];
  shape.deviation = strictness_ * std::sqrt(deviations.squaredNorm() / kWhitening.rows());
  return shape.deviation < config.max_deviation;
}

namespace {

/// One for each point that is seen, else zero.
Eigen::Matrix<float, kPoints, 1> weights_of(const HandShape& shape) {
  Eigen::Matrix<float, kPoints, 1> weights;
  for (int f = 0; f < kFingerCount; ++f) weights[f] = shape.tip_seen[f];
  for (int k = 0; k < kValleyCount; ++k) weights[kFingerCount + k] = shape.valley_seen[k];
  return weights;
}

/// The affine map that takes `from` to `to` where `weight` is not 0.
Eigen::Matrix<float, 2, 3> fit_affine(const Eigen::Matrix<float, 3, kPoints>& from,
                                      const Eigen::Matrix<float, 2, kPoints>& to,
                                      const Eigen::Matrix<float, kPoints, 1>& weight) {
  const Eigen::Matrix<float, kPoints, 3> weighted = weight.asDiagonal() * from.transpose();
  return to * weighted * (from * weighted).inverse();
}

}  // namespace

OwnShape::OwnShape(const HandModel& hand) noexcept : weight_(kEnoughFrames), layout_(hand.layout) {
  const auto valleys_m = hand.has_valleys ? hand.valleys_m : average_valleys_m(hand);
  mean_.topRows<2>() << hand.tips_m.topRows<2>().cast<float>(),
      valleys_m.topRows<2>().cast<float>();
  mean_.row(2).setOnes();
}

void OwnShape::learn(const HandShape& shape, float share) noexcept {
  layout_ = shape.layout;
  const Eigen::Matrix<float, 2, kPoints> points = points_of(shape);
  if (weight_ == 0) {
    // As if seen straight on, as far as the map to hands in general tells.
    const Eigen::Matrix2f linear = shape.image_hand.leftCols<2>();
    mean_.topRows<2>() = linear.inverse() * (points.colwise() - shape.image_hand.col(2));
    mean_.row(2).setOnes();
    weight_ = 1;
    return;
  }
  const Eigen::Matrix<float, 2, 3> map =
      fit_affine(mean_, points, Eigen::Matrix<float, kPoints, 1>::Ones());
  const Eigen::Matrix2f inverse = map.leftCols<2>().inverse();
  share = std::max(share, 1 / (weight_ + 1));
  mean_.topRows<2>() += share * (inverse * (points - map * mean_));
  weight_ = std::min(weight_ + 1, kEnoughFrames);
}

bool OwnShape::knows(const HandShape& shape) const noexcept {
  return is_known() && weights_of(shape).sum() >= kPoints - 4;
}

HandShape OwnShape::laid_on(const HandShape& shape) const noexcept {
  const Eigen::Matrix<float, 2, kPoints> points =
      fit_affine(mean_, points_of(shape), Eigen::Matrix<float, kPoints, 1>::Ones()) * mean_;
  HandShape laid = shape;
  for (int f = 0; f < kFingerCount; ++f) laid.tips[f] = points.col(f);
  for (int k = 0; k < kValleyCount; ++k) laid.valleys[k] = points.col(kFingerCount + k);
  return laid;
}

OwnShape::OddTip OwnShape::odd_tip(const HandShape& shape, float agree_m) const noexcept {
  constexpr float kUsual_m = 0.002f;
  OddTip odd;
  if (!knows(shape)) return odd;
  const Eigen::Matrix<float, 2, kPoints> points = points_of(shape);
  float least = agree_m;
  for (int f = 0; f < kFingerCount; ++f) {
    if (!shape.tip_seen[f]) continue;
    Eigen::Matrix<float, kPoints, 1> others = weights_of(shape);
    others[f] = 0;
    const Eigen::Matrix<float, 2, 3> map = fit_affine(mean_, points, others);
    const float px_per_m = std::sqrt(std::abs(map.leftCols<2>().determinant()));
    const Eigen::Matrix<float, 2, kPoints> rest = (points - map * mean_) / px_per_m;
    const float disagreement =
        std::sqrt(rest.colwise().squaredNorm().dot(others.transpose()) / others.sum());
    if (!(disagreement < least)) continue;
    least = disagreement;
    odd = {f, std::max(0.0f, rest.col(f).norm() - disagreement - kUsual_m), px_per_m};
  }
  return odd;
}

bool OwnShape::infer_tip(int finger, HandShape& shape) const noexcept {
  if (!knows(shape)) return false;
  const Eigen::Vector2f tip =
      fit_affine(mean_, points_of(shape), weights_of(shape)) * mean_.col(finger);
  if (tip.allFinite()) shape.tips[finger] = tip;
  return tip.allFinite();
}

bool fills_region(const HandShape& shape, const Mask& mask,
                  const HandShapeConfig& config) noexcept {
  return palm_fill(shape, mask) >= config.min_palm_fill &&
         finger_fill(shape, mask) >= config.min_finger_fill;
}

bool find_hand_shape(const CurvatureFinder& curvature, const Contour& contour, const Mask& mask,
                     float palm_radius, const HandShapeModel& model, const HandShapeConfig& config,
                     HandShape& best) noexcept {
  const auto tips = curvature.tips();
  const auto samples = curvature.samples();
  const int n = static_cast<int>(tips.size());
  if (n < kFingerCount) return false;

  // Which tips can be neighbouring fingers: valley[i][step] clockwise from i, or -1.
  const int max_step = n - (kFingerCount - 1);  // the other four are ahead
  constexpr int kMax = CurvatureFinder::kMaxTips;
  std::array<std::array<int, kMax>, kMax> valley;
  for (int i = 0; i < n; ++i)
    for (int step = 1; step <= max_step; ++step) {
      const int j = (i + step) % n;
      valley[i][step] = -1;
      const float distance = (tips[i].at - tips[j].at).norm();
      if (distance > 5 * palm_radius) continue;
      float depth = 0;
      const int at = curvature.valley(tips[i].sample, tips[j].sample, &depth);
      if (depth > config.min_valley_depth * palm_radius && depth < 4.5f * palm_radius)
        valley[i][step] = at;
    }

  best.deviation = static_cast<float>(config.max_deviation);
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
        shape.valleys[k] =
            samples[valley[clockwise[gap]][(clockwise[gap + 1] - clockwise[gap] + n) % n]];
      }
      if (!model.fit(config, shape)) continue;
      if (shape.deviation >= best.deviation || !fills_region(shape, mask, config) ||
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
    const int at = chain[length - 1];
    for (int step = 1; step <= max_step && turned + step < n; ++step) {
      if (valley[at][step] < 0) continue;
      chain[length] = (at + step) % n;
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
