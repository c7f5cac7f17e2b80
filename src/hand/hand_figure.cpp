// SPDX-License-Identifier: MIT
#include "handyar/stages/hand_figure.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>

namespace handyar {
namespace {

namespace statistics {
#include "figure_statistics.inc"
}
using statistics::kFigureMean_m, statistics::kFigureModes_m, statistics::kFigureSigma_m,
    statistics::kFigureNumbers;
static_assert(kFigureModes <= statistics::kFigureModes);

// A finger that bends at its root bends as much again at the next joint, half of it: fitted to
// rendered hands whose joints move (tools/hand_figure).
constexpr double kMiddleShare = 0.4;

constexpr int kTipOffset = 4 * kSphereCount;

Eigen::Matrix3d turn(const Eigen::Vector3d& axis, double angle_rad) {
  return Eigen::AngleAxisd(angle_rad, axis).toRotationMatrix();
}

/// From the palm in thumb_right to what is seen: z is mirrored for the back, x for thumb_left.
Eigen::Vector3d mirror(Face face, Layout layout) {
  return {layout == Layout::thumb_right ? 1.0 : -1.0, 1.0, face == Face::palm ? 1.0 : -1.0};
}

}  // namespace

PosedFigure pose_fingers(const HandFigure& figure, const Posture& posture) noexcept {
  PosedFigure posed{figure.centres_m, HandFigure::Centres::Zero(), HandFigure::Centres::Zero(),
                    figure.tips_m};
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
    const auto moved = [&](const Eigen::Vector3d& p) -> Eigen::Vector3d {
      return middle_m + bend_middle * (p - figure.centres_m.col(middle));
    };
    const Eigen::Vector3d axis = abduct * bend_axis;
    for (int joint = 1; joint < kFingerSpheres; ++joint) {
      const int s = sphere_of(f, joint);
      const Eigen::Vector3d p = joint == 1 ? middle_m : moved(figure.centres_m.col(s));
      posed.centres_m.col(s) = p;
      posed.by_abduction_m.col(s) = normal.cross(p - root_m);
      posed.by_flexion_m.col(s) = axis.cross(p - root_m) + kMiddleShare * axis.cross(p - middle_m);
    }
    posed.tips_m.col(f) = moved(figure.tips_m.col(f));
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

FigureDerivative figure_derivative(int sphere, Face face, Layout layout) noexcept {
  FigureDerivative d;
  for (int k = 0; k < kFigureModes; ++k)
    for (int i = 0; i < 4; ++i) d(i, k) = kFigureModes_m[k][4 * sphere + i];
  d.topRows<3>() = mirror(face, layout).asDiagonal() * d.topRows<3>();
  return d;
}

FigureEstimate estimate_figure(const HandModel& hand) noexcept {
  if (hand.figure) return *hand.figure;
  FigureEstimate estimate;
  if (hand.source == HandSource::average_adult) return estimate;
  const HandModel seen = hand.for_layout(Layout::thumb_right);
  // Tips that say nothing of their doubt were measured to about a millimetre; a hand whose scale is
  // assumed still tells the shape.
  constexpr double kMeasured_m = 0.001;
  constexpr int kCoordinates = 3 * kFingerCount;
  Eigen::Matrix<double, kCoordinates, kFigureModes> A;
  Eigen::Matrix<double, kCoordinates, 1> y, variance;
  for (int i = 0; i < kCoordinates; ++i) {
    const int f = i / 3, axis = i % 3, entry = kTipOffset + i;
    for (int k = 0; k < kFigureModes; ++k) A(i, k) = kFigureModes_m[k][entry];
    y[i] = seen.tips_m(axis, f) - kFigureMean_m[entry];
    const double stated = std::max(seen.tips_sigma_m(axis, f), kMeasured_m);
    variance[i] = stated * stated + kFigureSigma_m[entry] * kFigureSigma_m[entry];
    // Heights over the hand plane change sign with the face, which a model does not tell.
    if (axis == 2) variance[i] = 1.0;
  }
  const Eigen::Matrix<double, kFigureModes, kFigureModes> information =
      decltype(estimate.covariance)::Identity() +
      A.transpose() * variance.cwiseInverse().asDiagonal() * A;
  const Eigen::LLT<decltype(estimate.covariance)> llt(information);
  estimate.mean = llt.solve(A.transpose() * variance.cwiseInverse().cwiseProduct(y));
  estimate.covariance = llt.solve(decltype(estimate.covariance)::Identity());
  return estimate;
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

HandModel hand_of_figure(const FigureEstimate& figure, Layout layout) noexcept {
  HandModel hand;
  hand.layout = layout;
  hand.figure = figure;
  hand.tips_m = make_figure(figure.mean, Face::palm, layout).tips_m;
  for (int i = 0; i < 3 * kFingerCount; ++i) {
    Eigen::Matrix<double, kFigureModes, 1> row;
    for (int k = 0; k < kFigureModes; ++k) row[k] = kFigureModes_m[k][kTipOffset + i];
    hand.tips_sigma_m(i % 3, i / 3) = std::sqrt(row.dot(figure.covariance * row));
  }
  return hand;
}

}  // namespace handyar
