// SPDX-License-Identifier: MIT
#include "handyar/hand_outline.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace handyar {
namespace {

constexpr float kSpacing_m = 0.0085f;  // of points along the outline

struct Bone {
  Eigen::Vector2f from, to;
  float radius;

  float distance(const Eigen::Vector2f& p) const {
    const Eigen::Vector2f along = to - from, d = p - from;
    const float s = std::clamp(d.dot(along) / along.squaredNorm(), 0.0f, 1.0f);
    return (d - s * along).norm() - radius;
  }
};
using Bones = std::array<Bone, 2 * kFingerCount + kValleyCount>;

/// The hand as bones with flesh around them: fingers, what carries them in the palm, and webs.
Bones bones_of(const HandShape& hand_m) {
  constexpr std::array<float, kFingerCount> kRadius_m = {0.010f, 0.0085f, 0.0088f, 0.0083f,
                                                         0.0073f};
  constexpr float kWebFlesh_m = 0.008f;
  const auto wrist = [](const Eigen::Vector2f& p) {
    return Eigen::Vector2f(0.45f * p.x(), -0.085f);
  };
  Bones bones;
  for (int f = 0; f < kFingerCount; ++f) {
    const Eigen::Vector2f base = hand_m.finger_base(f), tip = hand_m.tips[f];
    bones[f] = {base, tip - kRadius_m[f] * (tip - base).normalized(), kRadius_m[f]};
    bones[kFingerCount + f] = {wrist(base), base, 1.3f * kRadius_m[f]};
  }
  for (int k = 0; k < kValleyCount; ++k) {
    const Eigen::Vector2f valley = hand_m.valleys[k];
    const Eigen::Vector2f down = (wrist(valley) - valley).normalized();
    bones[2 * kFingerCount + k] = {wrist(valley), valley + kWebFlesh_m * down, kWebFlesh_m};
  }
  return bones;
}

/// The values of u from `low` to `high`; none at first.
struct Interval {
  float low = std::numeric_limits<float>::max(), high = std::numeric_limits<float>::lowest();

  void add(float from, float to) {
    if (from > to) return;
    low = std::min(low, from);
    high = std::max(high, to);
  }
};

/// Where on the line p + u * d the flesh of a bone is.
Interval covered(const Bone& bone, const Eigen::Vector2f& p, const Eigen::Vector2f& d) {
  Interval u;
  const float d2 = d.squaredNorm();
  for (const Eigen::Vector2f& center : {bone.from, bone.to}) {
    const Eigen::Vector2f q = p - center;
    const float middle = -q.dot(d) / d2;
    const float rest = (bone.radius * bone.radius - q.squaredNorm()) / d2 + middle * middle;
    if (rest >= 0) u.add(middle - std::sqrt(rest), middle + std::sqrt(rest));
  }
  // Between the two ends: as far along the bone and as far across it.
  const Eigen::Vector2f bone_vector = bone.to - bone.from;
  const Eigen::Vector2f along = bone_vector.normalized(), across(-along.y(), along.x());
  float from = std::numeric_limits<float>::lowest(), to = std::numeric_limits<float>::max();
  const auto keep = [&](const Eigen::Vector2f& axis, float low, float high) {
    const float at = axis.dot(p - bone.from), step = axis.dot(d);
    if (step == 0 && (at < low || at > high)) to = std::numeric_limits<float>::lowest();
    if (step == 0) return;
    from = std::max(from, std::min((low - at) / step, (high - at) / step));
    to = std::min(to, std::max((low - at) / step, (high - at) / step));
  };
  keep(along, 0, bone_vector.norm());
  keep(across, -bone.radius, bone.radius);
  u.add(from, to);
  return u;
}

}  // namespace

HandOutline::HandOutline() {
  points_.reserve(256);
  draw(average_hand_shape());
}

void HandOutline::draw(const HandShape& hand_m) noexcept {
  constexpr float kPi = std::numbers::pi_v<float>;
  hand_ = hand_m;
  points_.clear();
  const Bones bones = bones_of(hand_m);
  const auto add = [&](int bone, const Eigen::Vector2f& center, const Eigen::Vector2f& normal) {
    constexpr float kWrist_m = -0.070f, kTouch_m = 0.0005f;
    const Eigen::Vector2f p = center + bones[bone].radius * normal;
    const bool hidden = std::ranges::any_of(
        bones, [&](const Bone& other) { return other.distance(p) < -kTouch_m; });
    if (!hidden && p.y() > kWrist_m && points_.size() < points_.capacity())
      points_.push_back({p, normal, bone});
  };
  for (int b = 0; b < static_cast<int>(bones.size()); ++b) {
    const float length = (bones[b].to - bones[b].from).norm();
    const Eigen::Vector2f along = (bones[b].to - bones[b].from) / length;
    const Eigen::Vector2f across(-along.y(), along.x());
    for (const float side : {-1.0f, 1.0f})
      for (float s = 0; s < length; s += kSpacing_m)
        add(b, bones[b].from + s * along, side * across);
    const int steps = static_cast<int>(kPi * bones[b].radius / kSpacing_m);
    for (int k = 1; k < steps; ++k) {
      const float angle = kPi * static_cast<float>(k) / static_cast<float>(steps);
      add(b, bones[b].to, std::cos(angle) * across + std::sin(angle) * along);
    }
  }
}

int HandOutline::edges_under(const EdgeMaps& edges, const AffineMap& maps_hand) const noexcept {
  const Eigen::Matrix2f linear = maps_hand.leftCols<2>(), normals = linear.inverse().transpose();
  int sum = 0;
  for (const Point& p : points_)
    sum += edges.edge_at(linear * p.at_m + maps_hand.col(2), normals * p.normal);
  return sum;
}

float HandOutline::support(const EdgeMaps& edges, const AffineMap& maps_hand) const noexcept {
  const float most = static_cast<float>(EdgeMaps::kMost) * static_cast<float>(points_.size());
  return static_cast<float>(edges_under(edges, maps_hand)) / most;
}

void HandOutline::shift(const EdgeMaps& edges, int reach, AffineMap& maps_hand) const noexcept {
  const AffineMap start = maps_hand;
  int best = edges_under(edges, start);
  for (int dy = -reach; dy <= reach; dy += 2)
    for (int dx = -reach; dx <= reach; dx += 2) {
      AffineMap shifted = start;
      shifted.col(2) += Eigen::Vector2f(static_cast<float>(dx), static_cast<float>(dy));
      const int sum = edges_under(edges, shifted);
      if (sum <= best) continue;
      best = sum;
      maps_hand = shifted;
    }
}

void HandOutline::align(const EdgeMaps& edges, std::span<const float> steps,
                        AffineMap& maps_hand) const noexcept {
  int best = edges_under(edges, maps_hand);
  const Eigen::Vector2f middle_m(0, 0.01f);
  for (const float step : steps)
    for (int k = 0; k < 12; ++k) {
      const float by = k % 2 == 0 ? step : -step, px = 2 * by, share = 0.1f * by;
      AffineMap changed = maps_hand;
      Eigen::Vector2f center = maps_hand * middle_m.homogeneous();
      switch (k / 2) {
        case 0:
          center.x() += px;
          break;
        case 1:
          center.y() += px;
          break;
        case 2:
          changed.leftCols<2>() = Eigen::Rotation2Df(share) * maps_hand.leftCols<2>();
          break;
        case 3:
          changed.leftCols<2>() *= 1 + share;
          break;
        case 4:
          changed.col(0) *= 1 + share;
          break;
        case 5:
          changed.col(1) *= 1 + share;
          break;
      }
      changed.col(2) = center - changed.leftCols<2>() * middle_m;
      const int sum = edges_under(edges, changed);
      if (sum <= best) continue;
      best = sum;
      maps_hand = changed;
    }
}

HandOutline::BentFinger HandOutline::bend(const EdgeMaps& edges, const AffineMap& maps_hand,
                                          int finger, const Bends& bends) const noexcept {
  const Eigen::Matrix2f linear = maps_hand.leftCols<2>(), normals = linear.inverse().transpose();
  const Eigen::Vector2f base = hand_.finger_base(finger);
  const Eigen::Vector2f along = (hand_.tips[finger] - base).normalized();
  BentFinger best;
  int highest = -1;
  for (const float turn_rad : bends.turns_rad)
    for (const float length : bends.lengths) {
      const Eigen::Matrix2f turn = Eigen::Rotation2Df(turn_rad).toRotationMatrix();
      const auto moved = [&](const Eigen::Vector2f& p) -> Eigen::Vector2f {
        const Eigen::Vector2f d = p - base;
        return base + turn * (d + (length - 1) * d.dot(along) * along);
      };
      int sum = 0, count = 0;
      for (const Point& p : points_) {
        if (p.bone != finger) continue;
        sum +=
            edges.edge_at(linear * moved(p.at_m) + maps_hand.col(2), normals * (turn * p.normal));
        ++count;
      }
      if (sum <= highest) continue;
      highest = sum;
      best = {moved(hand_.tips[finger]),
              static_cast<float>(sum) / static_cast<float>(EdgeMaps::kMost * std::max(count, 1))};
    }
  return best;
}

void draw_silhouette(const HandShape& hand, Mask& mask) noexcept {
  const HandOutline::AffineMap image_hand = hand.image_thumb_right();
  const Eigen::Matrix2f hand_image = image_hand.leftCols<2>().inverse();
  const Bones bones = bones_of(hand.in_hand_plane());
  for (int v = 0; v < mask.height; ++v) {
    const Eigen::Vector2f p =
        hand_image * (Eigen::Vector2f(0, static_cast<float>(v)) - image_hand.col(2));
    for (const Bone& bone : bones) {
      const Interval u = covered(bone, p, hand_image.col(0));
      const float limit = static_cast<float>(mask.width);
      if (!(u.low < limit && u.high >= 0)) continue;
      mask.set_run(v, static_cast<int>(std::ceil(std::max(u.low, 0.0f))),
                   static_cast<int>(std::min(u.high + 1, limit)));
    }
  }
}

}  // namespace handyar
