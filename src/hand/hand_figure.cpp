// SPDX-License-Identifier: MIT
#include "handyar/stages/hand_figure.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "hand/figure_statistics.hpp"

namespace handyar {
namespace {

// A finger that bends at its root bends by so much of that again at the next joint: fitted to
// rendered hands whose joints move (tools/hand_figure).
constexpr double kMiddleShare = 0.4;

Eigen::Matrix3d turn(const Eigen::Vector3d& axis, double angle_rad) {
  return Eigen::AngleAxisd(angle_rad, axis).toRotationMatrix();
}

/// Of a sphere's coordinates, how far the average hand has it from the middle of all.
constexpr auto kFromMiddle_m = [] {
  std::array<double, 4 * kSphereCount> from{};
  for (int axis = 0; axis < 3; ++axis) {
    double middle = 0;
    for (int s = 0; s < kSphereCount; ++s) middle += kFigureMean_m[4 * s + axis] / kSphereCount;
    for (int s = 0; s < kSphereCount; ++s)
      from[4 * s + axis] = kFigureMean_m[4 * s + axis] - middle;
  }
  return from;
}();

/// By what share each mode makes a hand larger: its spheres laid on the mean ones, least squares.
constexpr auto kLarger = [] {
  double square = 0;
  for (const double m : kFromMiddle_m) square += m * m;
  std::array<double, kFigureModes> larger{};
  for (int k = 0; k < kFigureModes; ++k)
    for (int i = 0; i < 4 * kSphereCount; ++i)
      larger[k] += kFromMiddle_m[i] * kFigureModes_m[k][i] / square;
  return larger;
}();

/// From the palm in thumb_right to what is seen: z is mirrored for the back, x for thumb_left.
Eigen::Vector3d mirror(Face face, Layout layout) {
  return {layout == Layout::thumb_right ? 1.0 : -1.0, 1.0, face == Face::palm ? 1.0 : -1.0};
}

}  // namespace

Posture Posture::towards(const Posture& other, double share) const noexcept {
  const auto between = [share](double a, double b) { return a + share * (b - a); };
  Posture to;
  for (int f = 0; f < kFingerCount; ++f) {
    to.abduction_rad[f] = between(abduction_rad[f], other.abduction_rad[f]);
    to.flexion_rad[f] = between(flexion_rad[f], other.flexion_rad[f]);
  }
  to.thumb_bend_rad = between(thumb_bend_rad, other.thumb_bend_rad);
  return to;
}

PosedFigure pose_fingers(const HandFigure& figure, const Posture& posture) noexcept {
  PosedFigure posed{figure.centres_m, HandFigure::Centres::Zero(), HandFigure::Centres::Zero(),
                    HandFigure::Centres::Zero(), figure.tips_m};
  const double to_thumb = figure.layout == Layout::thumb_right ? -1 : 1;
  const double to_palm = figure.face == Face::palm ? 1 : -1;
  const Eigen::Vector3d normal(0, 0, to_thumb);
  for (int f = 0; f < kFingerCount; ++f) {
    const int root = sphere_of(f, 0), middle = sphere_of(f, 1), end = sphere_of(f, 3);
    const Eigen::Vector3d root_m = figure.centres_m.col(root);
    const Eigen::Vector3d along = figure.centres_m.col(end) - root_m;
    // Turning about this axis lifts the fingertip towards the palm.
    const Eigen::Vector3d bend_axis =
        Eigen::Vector3d(along.y(), -along.x(), 0).normalized() * to_palm;
    const double flexion = posture.flexion_rad[f];
    const Eigen::Matrix3d abduct = turn(normal, posture.abduction_rad[f]);
    const Eigen::Matrix3d bend = abduct * turn(bend_axis, flexion);
    const Eigen::Matrix3d bend_middle = bend * turn(bend_axis, kMiddleShare * flexion);
    const Eigen::Vector3d middle_m = root_m + bend * (figure.centres_m.col(middle) - root_m);
    // In the palm plane the thumb alone bends, at the joint after its root and at the last alike.
    const Eigen::Matrix3d curve = turn(normal, f == 0 ? posture.thumb_bend_rad : 0);
    const Eigen::Vector3d last_bone = figure.centres_m.col(end - 1) - figure.centres_m.col(middle);
    const auto moved = [&](const Eigen::Vector3d& p, bool last) -> Eigen::Vector3d {
      const Eigen::Vector3d from_middle = p - figure.centres_m.col(middle);
      const Eigen::Vector3d curved =
          last ? (last_bone + curve * (from_middle - last_bone)).eval() : from_middle;
      return middle_m + bend_middle * (curve * curved);
    };
    const Eigen::Vector3d axis = abduct * bend_axis, curve_axis = bend_middle * normal;
    for (int joint = 1; joint < kFingerSpheres; ++joint) {
      const int s = sphere_of(f, joint);
      const bool last = joint == kFingerSpheres - 1;
      const Eigen::Vector3d p = joint == 1 ? middle_m : moved(figure.centres_m.col(s), last);
      posed.centres_m.col(s) = p;
      if (f == 0) {
        posed.by_thumb_bend_m.col(s) = curve_axis.cross(p - middle_m);
        if (last) posed.by_thumb_bend_m.col(s) += curve_axis.cross(p - posed.centres_m.col(s - 1));
      }
      posed.by_abduction_m.col(s) = normal.cross(p - root_m);
      posed.by_flexion_m.col(s) = axis.cross(p - root_m) + kMiddleShare * axis.cross(p - middle_m);
    }
    posed.tips_m.col(f) = moved(figure.tips_m.col(f), true);
  }
  return posed;
}

std::span<const std::array<std::int8_t, 3>> figure_hulls() noexcept {
  static constexpr auto kHulls = [] {
    std::array<std::array<std::int8_t, 3>, statistics::kFigureHulls> hulls{};
    for (int i = 0; i < statistics::kFigureHulls; ++i)
      for (int k = 0; k < 3; ++k)
        hulls[i][k] = static_cast<std::int8_t>(statistics::kFigureHullSpheres[i][k]);
    return hulls;
  }();
  return kHulls;
}

HandFigure make_figure(const FigureCoefficients& coefficients, Face face, Layout layout) noexcept {
  Eigen::Matrix<double, kFigureNumbers, 1> v;
  for (int i = 0; i < kFigureNumbers; ++i) {
    v[i] = kFigureMean_m[i];
    for (int k = 0; k < kFigureModes; ++k) v[i] += kFigureModes_m[k][i] * coefficients[k];
  }
  HandFigure figure;
  figure.face = face;
  figure.layout = layout;
  const Eigen::Vector3d m = mirror(face, layout);
  for (int s = 0; s < kSphereCount; ++s) {
    figure.centres_m.col(s) = m.cwiseProduct(v.segment<3>(4 * s));
    figure.radii_m[s] = v[4 * s + 3];
  }
  for (int f = 0; f < kFingerCount; ++f)
    figure.tips_m.col(f) = m.cwiseProduct(v.segment<3>(kTipOffset + 3 * f));
  return figure;
}

double hand_length_m(const HandFigure& figure) noexcept {
  const Eigen::Vector3d wrist =
      0.5 * (figure.centres_m.col(kWristThumb) + figure.centres_m.col(kWristLittle));
  return (figure.tips_m.col(static_cast<int>(Finger::middle)) - wrist).norm();
}

namespace {

/// Of the mean of all figures.
double mean_size() {
  const FigureCoefficients mean = FigureCoefficients::Zero();
  return hand_length_m(make_figure(mean, Face::palm, Layout::thumb_right)) / kAverageHandLength_m;
}

}  // namespace

double relative_size(const FigureCoefficients& coefficients) noexcept {
  return mean_size() + relative_size_derivative().dot(coefficients);
}

FigureCoefficients relative_size_derivative() noexcept {
  return mean_size() * Eigen::Map<const FigureCoefficients>(kLarger.data());
}

HandFigure make_figure(const HandModel& hand, Face face, Layout layout) noexcept {
  const FigureCoefficients mean = estimate_figure(hand).mean;
  HandFigure figure = make_figure(mean, face, layout);
  if (!hand.scale_assumed()) return figure;
  const double factor = 1 / relative_size(mean);
  figure.centres_m *= factor;
  figure.radii_m *= factor;
  figure.tips_m *= factor;
  return figure;
}

FigureDerivative figure_derivative(int sphere, Face face, Layout layout) noexcept {
  FigureDerivative d;
  for (int k = 0; k < kFigureModes; ++k)
    for (int i = 0; i < 4; ++i) d(i, k) = kFigureModes_m[k][4 * sphere + i];
  d.topRows<3>() = mirror(face, layout).asDiagonal() * d.topRows<3>();
  return d;
}

std::span<const double, kFingerCount> closing_rad() noexcept {
  return statistics::kFigureClosing_rad;
}

Eigen::Matrix<double, kFingerCount, kFingerCount> abduction_covariance_rad2() noexcept {
  using Abductions = Eigen::Matrix<double, kFingerCount, 1>;
  Abductions sigma;
  for (int f = 0; f < kFingerCount; ++f) sigma[f] = finger_sigma_rad(f);
  const Abductions together = kClosingSigma * Eigen::Map<const Abductions>(closing_rad().data());
  Eigen::Matrix<double, kFingerCount, kFingerCount> covariance = together * together.transpose();
  covariance.diagonal() += sigma.cwiseAbs2();
  return covariance;
}

FigureEstimate rescaled(const FigureEstimate& figure, double factor) noexcept {
  using Square = decltype(figure.covariance);
  Square H = 1e-6 * Square::Identity();
  FigureCoefficients g = FigureCoefficients::Zero();
  for (int i = 0; i < kFigureNumbers; ++i) {
    FigureCoefficients row;
    for (int k = 0; k < kFigureModes; ++k) row[k] = kFigureModes_m[k][i];
    const double weight = 1 / (kFigureSigma_m[i] * kFigureSigma_m[i] + 1e-8);
    const double wanted_m = factor * (kFigureMean_m[i] + row.dot(figure.mean)) - kFigureMean_m[i];
    H += weight * row * row.transpose();
    g += weight * wanted_m * row;
  }
  return {H.llt().solve(g), figure.covariance};
}

HandModel hand_of_figure(const FigureEstimate& figure, Layout layout, bool average_scale) noexcept {
  HandModel hand;
  hand.layout = layout;
  hand.figure = figure;
  hand.average_scale = average_scale;
  const double factor = average_scale ? 1 / relative_size(figure.mean) : 1;
  hand.tips_m = factor * make_figure(figure.mean, Face::palm, layout).tips_m;
  for (int i = 0; i < 3 * kFingerCount; ++i) {
    Eigen::Matrix<double, kFigureModes, 1> row;
    for (int k = 0; k < kFigureModes; ++k) row[k] = kFigureModes_m[k][kTipOffset + i];
    hand.tips_sigma_m(i % 3, i / 3) = factor * std::sqrt(row.dot(figure.covariance * row));
  }
  return hand;
}

}  // namespace handyar
