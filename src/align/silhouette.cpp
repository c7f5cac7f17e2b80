// SPDX-License-Identifier: MIT
#include "align/silhouette.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "align/topology.hpp"
#include "pose/so3.hpp"
#include "vectorised.hpp"

namespace handyar {
namespace {

// Below the wrist comes the forearm, of about this length while a hand is in view.
constexpr double kForearm_m = 0.12;

/// From one of the capsules.
HANDYAR_ALWAYS_INLINE float distance_to(const Capsules& c, int k, float x_px, float y_px) {
  const float wx = x_px - c.x[k], wy = y_px - c.y[k];
  const float along = wx * c.dx[k] + wy * c.dy[k];
  const float across = std::abs(wx * c.dy[k] - wy * c.dx[k]);
  float t = (along - across * c.slope[k]) * c.inverse_length[k];
  // A tapered capsule's surface belongs to that disc between both ends whose normal meets it.
  // Bounds come first: so WebAssembly has one instruction for it.
  t = std::min(1.0f, std::max(0.0f, t));
  const float rest = along - t * c.length[k];
  return std::sqrt(rest * rest + across * across) - (c.r0[k] + t * c.dr[k]);
}

/// From the nearest of the first `count` capsules, rounded up to whole vectors.
HANDYAR_VECTORISED float distance_to_nearest(const Capsules& c, int count, float x_px,
                                             float y_px) noexcept {
  constexpr int kLanes = 8;  // each with a minimum of its own: one alone would be a chain
  std::array<float, kLanes> least;
  least.fill(std::numeric_limits<float>::max());
  for (int i = 0; i < count; i += kLanes)
    for (int lane = 0, k = i; lane < kLanes; ++lane, ++k)
      least[lane] = std::min(least[lane], distance_to(c, k, x_px, y_px));
  return *std::min_element(least.begin(), least.end());
}

/// Whether one of the first `count` sheets covers a point.
HANDYAR_VECTORISED bool covered(const Sheets& s, int count, float x_px, float y_px) noexcept {
  int sheets = 0;
  for (int i = 0; i < count; ++i) {
    int left = 1, right = 1;
    for (int k = 0; k < 3; ++k) {
      const float side = s.dx[k][i] * (y_px - s.y[k][i]) - s.dy[k][i] * (x_px - s.x[k][i]);
      left &= side > 0;
      right &= side < 0;
    }
    sheets |= left | right;
  }
  return sheets != 0;
}

}  // namespace

Silhouette::Silhouette(Appearance appearance, const HandState& state, const HandView& view) noexcept
    : f_px_(view.f_px()) {
  const HandFigure figure = make_figure(state.figure, appearance.face, appearance.layout);
  const PosedFigure posed = pose_fingers(figure, state.posture);
  project(figure, posed, state, view);
  if (!valid_) return;
  add_capsules();
  add_sheets();
}

void Silhouette::project(const HandFigure& figure, const PosedFigure& posed, const HandState& state,
                         const HandView& view) noexcept {
  const Eigen::Matrix3d R = state.T_camera_hand.linear();
  const Eigen::Vector3d t = state.T_camera_hand.translation();
  depth_m_ = (view.R_view_camera() * t).z();
  const auto disc = [&](int i, const Eigen::Vector3d& p, double radius_m) {
    const double inverse = 1 / std::max(p.z(), kNearest_m);
    if (p.z() < kNearest_m + radius_m) valid_ = false;
    x_[i] = static_cast<float>(f_px_ * p.x() * inverse);
    y_[i] = static_cast<float>(f_px_ * p.y() * inverse);
    r_[i] = static_cast<float>(f_px_ * radius_m * inverse);
  };
  for (int s = 0; s < kSphereCount; ++s) {
    const double radius_m = figure.radii_m[s];
    const Eigen::Vector3d turned = R * posed.centres_m.col(s);
    const Eigen::Vector3d p = view.R_view_camera() * (turned + t);
    disc(s, p, radius_m);
    const double k = f_px_ / std::max(p.z(), kNearest_m), depth = k / std::max(p.z(), kNearest_m);
    Eigen::Matrix3d by_point;
    by_point << k, 0, -depth * p.x(), 0, k, -depth * p.y(), 0, 0, -depth * radius_m;
    by_point = (by_point * view.R_view_camera()).eval();
    J_[s].leftCols<3>() = -by_point * so3::skew(turned);
    J_[s].middleCols<3>(3) = by_point;
    J_[s].col(6) = by_point * (R * posed.by_abduction_m.col(s));
    J_[s].col(7) = by_point * (R * posed.by_flexion_m.col(s));
    J_[s].col(8) = by_point * (R * posed.by_thumb_bend_m.col(s));
    const FigureDerivative by_figure = figure_derivative(s, figure.face, figure.layout);
    J_[s].rightCols<kFigureModes>() = by_point * R * by_figure.topRows<3>();
    J_[s].bottomRightCorner<1, kFigureModes>() += k * by_figure.bottomRows<1>();
  }
  for (int k = 0; k < 2; ++k) {
    const int wrist = kWristThumb + k;
    const Eigen::Vector3d end = posed.centres_m.col(wrist) - Eigen::Vector3d(0, kForearm_m, 0);
    const Eigen::Vector3d p = view.R_view_camera() * (R * end + t);
    const double radius_m = figure.radii_m[wrist];
    disc(kForearm + k,
         p.z() > kNearest_m + radius_m
             ? p
             : view.R_view_camera() * (R * posed.centres_m.col(wrist) + t),
         radius_m);
  }
}

void Silhouette::add_capsules() noexcept {
  const Topology& t = topology();
  Capsules& c = capsules_;
  capsule_count_ = t.pair_count;
  for (int i = 0; i < Capsules::kMost; ++i) {
    int a = i < t.pair_count ? t.pairs[i].a : t.pairs[0].a,
        b = i < t.pair_count ? t.pairs[i].b : t.pairs[0].b;
    if (r_[b] > r_[a]) std::swap(a, b);
    const float dx = x_[b] - x_[a], dy = y_[b] - y_[a], length = std::hypot(dx, dy),
                dr = r_[b] - r_[a];
    c.x[i] = x_[a];
    c.y[i] = y_[a];
    c.r0[i] = r_[a];
    if (length <= -dr + 1e-3f) {  // one disc lies in the other
      c.dx[i] = 1;
      c.dy[i] = c.length[i] = c.inverse_length[i] = c.slope[i] = c.dr[i] = 0;
      continue;
    }
    c.dx[i] = dx / length;
    c.dy[i] = dy / length;
    c.length[i] = length;
    c.inverse_length[i] = 1 / length;
    const float sine = -dr / length;
    c.slope[i] = sine / std::sqrt(1 - sine * sine);
    c.dr[i] = dr;
  }
}

void Silhouette::add_sheets() noexcept {
  const Topology& t = topology();
  for (int i = 0; i < t.sheet_count; ++i)
    for (int k = 0; k < 3; ++k) {
      const int from = t.sheets[i][k], to = t.sheets[i][(k + 1) % 3];
      sheets_.x[k][i] = x_[from];
      sheets_.y[k][i] = y_[from];
      sheets_.dx[k][i] = x_[to] - x_[from];
      sheets_.dy[k][i] = y_[to] - y_[from];
    }
}

int Silhouette::own_capsules() noexcept { return topology().own_pairs; }
int Silhouette::sheet_count() noexcept { return topology().own_sheets; }

std::size_t Silhouette::capsule_polygon(
    int capsule, float grow_px, std::array<Eigen::Vector2f, kMostCorners>& corners) const noexcept {
  const auto [a, b] = topology().pairs[capsule];
  const Eigen::Vector2f from = disc_px(a), along = disc_px(b) - from;
  const float angle = std::atan2(along.y(), along.x());
  // Half a turn around each end; a little wide where the capsule tapers, by less than a pixel.
  constexpr int kHalf = kMostCorners / 2;
  for (int i = 0; i < kMostCorners; ++i) {
    const bool far_end = i < kHalf;
    const int k = far_end ? i : i - kHalf;
    const float turn = angle + static_cast<float>(std::numbers::pi) *
                                   ((far_end ? -0.5f : 0.5f) + static_cast<float>(k) / (kHalf - 1));
    const int s = far_end ? b : a;
    corners[i] = disc_px(s) + (r_[s] + grow_px) * Eigen::Vector2f(std::cos(turn), std::sin(turn));
  }
  return kMostCorners;
}

std::size_t Silhouette::sheet_polygon(
    int sheet, std::array<Eigen::Vector2f, kMostCorners>& corners) const noexcept {
  for (int k = 0; k < 3; ++k) corners[k] = disc_px(topology().sheets[sheet][k]);
  return 3;
}

float Silhouette::distance_px(const Eigen::Vector2f& p) const noexcept {
  const float least = distance_to_nearest(capsules_, capsule_count_, p.x(), p.y());
  const bool inside = least > 0 && covered(sheets_, topology().sheet_count, p.x(), p.y());
  return inside ? -1.0f : least;
}

bool Silhouette::others_cover(int finger, const Eigen::Vector2f& p) const noexcept {
  for (int i = 0; i < own_capsules(); ++i) {
    const auto [a, b] = topology().pairs[i];
    const bool own = finger_of(a) == finger && finger_of(b) == finger;
    if (!own && capsule_distance_px(i, p) < 0) return true;
  }
  return covered(sheets_, sheet_count(), p.x(), p.y());
}

float Silhouette::capsule_distance_px(int capsule, const Eigen::Vector2f& p) const noexcept {
  return distance_to(capsules_, capsule, p.x(), p.y());
}

OutlinePlace Silhouette::place(const OutlineAnchor& k) const noexcept {
  OutlinePlace place;
  if (k.a == k.b) {
    place.normal = k.normal;
    place.px = disc_px(k.a) + r_[k.a] * place.normal;
    return place;
  }
  const Eigen::Vector2f from = disc_px(k.a), to = disc_px(k.b);
  const Eigen::Vector2f step = to - from;
  const float length = std::max(step.norm(), 1e-3f);
  const Eigen::Vector2f d = step / length, across(-d.y() * k.side, d.x() * k.side);
  const float sine = std::clamp((r_[k.a] - r_[k.b]) / length, -0.99f, 0.99f);
  place.normal = sine * d + std::sqrt(1 - sine * sine) * across;
  place.px =
      (1 - k.along) * (from + r_[k.a] * place.normal) + k.along * (to + r_[k.b] * place.normal);
  return place;
}

Eigen::Matrix<double, 1, kHandFreedoms> Silhouette::derivative(
    const OutlineAnchor& k, const OutlinePlace& place) const noexcept {
  Eigen::Matrix<double, 1, kHandFreedoms> row = Eigen::Matrix<double, 1, kHandFreedoms>::Zero();
  const Eigen::RowVector3d outwards(place.normal.x(), place.normal.y(), 1);
  const auto add = [&](int sphere, double weight) {
    const Eigen::Matrix<double, 1, kOwnFreedoms> j = weight * outwards * J_[sphere];
    row.head<6>() += j.head<6>();
    row.tail<kFigureModes>() += j.tail<kFigureModes>();
    const int finger = finger_of(sphere);
    if (finger == kFingerCount) return;
    row[kAbductionAt + finger] += j[6];
    row[kFlexionAt + finger] += j[7];
    row[kThumbBendAt] += j[8];
  };
  if (k.a == k.b) {
    add(k.a, 1);
  } else {
    add(k.a, 1 - k.along);
    add(k.b, k.along);
  }
  row[kBoundaryAt] = k.furrow ? 0 : 1;
  return row;
}

Eigen::Vector2f Silhouette::direction(int finger) const noexcept {
  const int end = sphere_of(finger, kFingerSpheres - 1);
  return (disc_px(end) - disc_px(end - 1)).normalized();
}

Eigen::Vector2f Silhouette::tip_px(int finger) const noexcept {
  const int end = sphere_of(finger, kFingerSpheres - 1);
  return disc_px(end) + r_[end] * direction(finger);
}

PlaceDerivative Silhouette::tip_derivative(int finger) const noexcept {
  Eigen::Matrix<double, 2, 3> by_disc = Eigen::Matrix<double, 2, 3>::Identity();
  by_disc.col(2) = direction(finger).cast<double>();
  return place_derivative(finger, sphere_of(finger, kFingerSpheres - 1), by_disc);
}

PlaceDerivative Silhouette::root_derivative(int finger) const noexcept {
  return place_derivative(finger, sphere_of(finger, 0), Eigen::Matrix<double, 2, 3>::Identity());
}

PlaceDerivative Silhouette::place_derivative(
    int finger, int sphere, const Eigen::Matrix<double, 2, 3>& by_disc) const noexcept {
  const Eigen::Matrix<double, 2, kOwnFreedoms> own = by_disc * J_[sphere];
  PlaceDerivative J = PlaceDerivative::Zero();
  J.leftCols<6>() = own.leftCols<6>();
  J.col(kAbductionAt + finger) = own.col(6);
  J.col(kFlexionAt + finger) = own.col(7);
  J.col(kThumbBendAt) = own.col(8);
  J.rightCols<kFigureModes>() = own.rightCols<kFigureModes>();
  return J;
}

}  // namespace handyar
