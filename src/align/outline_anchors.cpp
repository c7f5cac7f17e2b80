// SPDX-License-Identifier: MIT
// Which places of a silhouette's outline are looked at.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "align/silhouette.hpp"
#include "align/topology.hpp"

namespace handyar {
namespace {

// With no more than this beside a place on the outline it cannot be told what lies there.
constexpr double kLeast_m = kEitherSide * kFinestSegment_m;
// Farther than this from the outline nothing is asked for, nor are colours learned.
constexpr double kReach_m = 0.0135;
// A furrow is two pixels wide, and has two of each finger beside it.
constexpr float kFurrowAndSide_px = 3;
/// Spheres whose own roundness shows: fingertips, webs, the heel.
constexpr std::array<std::uint8_t, 10> kRound{3, 7, 11, 15, 19, 20, 21, 22, 23, kHeel};

}  // namespace

bool Silhouette::try_anchor(OutlineAnchor anchor, Anchors& anchors, int& count) const noexcept {
  if (count == kMaxAnchors) return false;
  const OutlinePlace at = place(anchor);
  const float first = 0.5f;
  if (distance_px(at.px + first * at.normal) < 0.3f * first) return false;  // behind another part
  const float reach = static_cast<float>(to_px(kReach_m));
  const auto least = static_cast<float>(to_px(kLeast_m));
  // Free ground ends where another part of the figure begins; each step is as long as is surely
  // free.
  float r = kEitherSide * std::max(1.0f, static_cast<float>(to_px(kFinestSegment_m)));
  while (r < reach) {
    const float d = distance_px(at.px + r * at.normal);
    if (d < 0.35f * r) {
      r = std::min(r, r + d) * 0.75f;
      break;
    }
    r += std::max(d, 1.0f);
  }
  anchor.outside_px = std::min(r, reach);
  if (anchor.outside_px < least) return false;
  anchor.inside_px = std::min(1.5f * thickness_px(anchor), reach);
  if (anchor.inside_px < least) return false;
  anchors[count++] = anchor;
  return true;
}

bool Silhouette::try_furrow(OutlineAnchor anchor, Anchors& anchors, int& count) const noexcept {
  const int finger = finger_of(anchor.a);
  if (count == kMaxAnchors || finger == kFingerCount || finger_of(anchor.b) != finger) return false;
  if (anchor.a == sphere_of(finger, 0)) return false;  // there fingers have grown together
  const float thick = thickness_px(anchor);
  if (thick < kFurrowAndSide_px) return false;
  const OutlinePlace at = place(anchor);
  float nearest = std::numeric_limits<float>::max();
  for (int i = 0; i < own_capsules(); ++i) {
    const auto [a, b] = topology().pairs[i];
    const int other = finger_of(a) == finger_of(b) ? finger_of(a) : kFingerCount;
    if (other == finger) continue;
    const float d = capsule_distance_px(i, at.px);
    if (other != kFingerCount)
      nearest = std::min(nearest, d);
    else if (d < 0)
      return false;  // it lies on the palm
  }
  if (nearest > static_cast<float>(to_px(kLeast_m)) || nearest < -thick) return false;
  anchor.inside_px = anchor.outside_px = thick;
  anchor.furrow = true;
  anchors[count++] = anchor;
  return true;
}

float Silhouette::thickness_px(const OutlineAnchor& anchor) const noexcept {
  return anchor.a == anchor.b ? r_[anchor.a]
                              : (1 - anchor.along) * r_[anchor.a] + anchor.along * r_[anchor.b];
}

int Silhouette::choose(float spacing_px, Anchors& anchors) const noexcept {
  const Topology& t = topology();
  int count = 0;
  for (int i = 0; i < t.own_pairs; ++i) {
    const auto [a, b] = t.pairs[i];
    if (a == kWristThumb && b == kWristLittle) continue;  // the wrist has no outline of its own
    const float length = (disc_px(b) - disc_px(a)).norm(), dr = r_[a] - r_[b];
    if (length <= std::abs(dr) + 0.5f) continue;
    const float tangent = std::sqrt(length * length - dr * dr);
    const int n = std::max(1, static_cast<int>(std::lround(tangent / spacing_px)));
    for (const int side : {-1, 1})
      for (int k = 0; k < n; ++k) {
        const OutlineAnchor anchor{a, b, static_cast<std::int8_t>(side), (k + 0.5f) / n};
        if (!try_anchor(anchor, anchors, count)) try_furrow(anchor, anchors, count);
      }
  }
  for (const std::uint8_t s : kRound) {
    const int n =
        std::max(6, static_cast<int>(std::lround(2 * std::numbers::pi * r_[s] / spacing_px)));
    // At a fingertip angles count from the finger's direction: places turn with it.
    float from = 0;
    if (s < kFirstWeb) {
      const Eigen::Vector2f d = disc_px(s) - disc_px(s - 1);
      from = std::atan2(d.y(), d.x());
    }
    for (int k = 0; k < n; ++k) {
      const float angle = from + static_cast<float>(2 * std::numbers::pi * k / n);
      try_anchor({s, s, 1, 0, {std::cos(angle), std::sin(angle)}}, anchors, count);
    }
  }
  return count;
}

}  // namespace handyar
