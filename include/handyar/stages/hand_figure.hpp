// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

#include "handyar/hand_model.hpp"

namespace handyar {

/// The spheres of the figure: four along each finger from its root to its tip, four webs, the two
/// sides of the wrist, the heel of the hand below the little finger.
inline constexpr int kFingerSpheres = 4;
inline constexpr int kFirstWeb = kFingerCount * kFingerSpheres;
inline constexpr int kWristThumb = 24, kWristLittle = 25, kHeel = 26, kSphereCount = 27;
constexpr int sphere_of(int finger, int joint) noexcept { return kFingerSpheres * finger + joint; }
/// The finger that a sphere moves with; kFingerCount: the palm.
constexpr int finger_of(int sphere) noexcept {
  return sphere < kFirstWeb ? sphere / kFingerSpheres : kFingerCount;
}

/// How the fingers stand against the person's rest posture: turned in the palm plane towards the
/// thumb (abduction), bent towards the palm (flexion); and by how much the thumb's two last joints
/// bend in the palm plane, away from the fingers.
struct Posture {
  std::array<double, kFingerCount> abduction_rad{}, flexion_rad{};
  double thumb_bend_rad = 0;

  /// So much of the way to another.
  Posture towards(const Posture& other, double share) const noexcept;
};

/// A solid hand: spheres, and the convex hulls of two or three of them (tapered capsules and palm
/// sheets, see figure_hulls()). In the hand frame of the face and layout in which it is seen, in
/// metres.
struct HandFigure {
  using Centres = Eigen::Matrix<double, 3, kSphereCount>;
  using Radii = Eigen::Matrix<double, 1, kSphereCount>;
  using Tips = Eigen::Matrix<double, 3, kFingerCount>;

  Face face = Face::palm;
  Layout layout = Layout::thumb_right;
  Centres centres_m = Centres::Zero();
  Radii radii_m = Radii::Zero();
  Tips tips_m = Tips::Zero();
};

/// A figure whose fingers have moved, and how each sphere's centre moves with its own finger.
struct PosedFigure {
  HandFigure::Centres centres_m, by_abduction_m, by_flexion_m, by_thumb_bend_m;
  HandFigure::Tips tips_m;
};

/// Fingers turn about their roots in the palm plane; they bend at the root and by a share of it at
/// the joint after it. The thumb's joints after its root turn in the palm plane, too.
PosedFigure pose_fingers(const HandFigure& figure, const Posture& posture) noexcept;

/// How fingers turn when those of an average hand at rest, all apart, come to lie side by side
/// (abduction, radians): the four along the middle finger, the thumb along the index finger.
std::span<const double, kFingerCount> closing_rad() noexcept;

/// How lively fingers stray from rest, standard deviations: a finger's turn and bend, the thumb's,
/// which moves farther, and how far all close together, 1 is side by side.
constexpr double finger_sigma_rad(int finger) { return finger == 0 ? 0.2 : 0.08; }
inline constexpr double kClosingSigma = 0.25;

/// Covariance of the five abductions by all of these.
Eigen::Matrix<double, kFingerCount, kFingerCount> abduction_covariance_rad2() noexcept;

/// Triples of spheres; the third is -1 where a hull has two.
std::span<const std::array<std::int8_t, 3>> figure_hulls() noexcept;

/// The figure of a person's coefficients (FigureCoefficients).
HandFigure make_figure(const FigureCoefficients& coefficients, Face face, Layout layout) noexcept;

/// The figure of a hand model, as large as the model says: where its size was not measured the
/// coefficients tell the shape alone.
HandFigure make_figure(const HandModel& hand, Face face, Layout layout) noexcept;

/// From the crease of the wrist to the tip of the middle finger.
double hand_length_m(const HandFigure& figure) noexcept;

/// How large a figure is: 1 as the average adult's (kAverageHandLength_m), by all its spheres.
/// Linear in the coefficients; a picture does not tell it.
double relative_size(const FigureCoefficients& coefficients) noexcept;
FigureCoefficients relative_size_derivative() noexcept;

/// How sphere `sphere` moves and grows with each coefficient: x, y, z in metres, radius.
using FigureDerivative = Eigen::Matrix<double, 4, kFigureModes>;
FigureDerivative figure_derivative(int sphere, Face face, Layout layout) noexcept;

/// What a hand model says of the person: its figure where it has one; else the figures of people
/// at large, conditioned on its fingertips, each as well known as it states. An average hand is
/// people at large. Where hardly a hand at rest has such fingertips, they were measured on one that
/// held its fingers otherwise, in a frame that may be turned in the hand plane: its figure is the
/// one at rest, and poses are those of that one's hand frame.
FigureEstimate estimate_figure(const HandModel& hand) noexcept;

/// What fingertips say of a person whose figure is known so well already, but for its size, say,
/// and who held the fingers so when the fingertips were measured.
FigureEstimate estimate_figure(const HandModel& hand, const FigureEstimate& person,
                               const Posture& held) noexcept;

/// The figure of a hand of the same shape that is `factor` times as large, as well as the modes can
/// say it.
FigureEstimate rescaled(const FigureEstimate& figure, double factor) noexcept;

/// A person's figure as a hand model: fingertips of the outstretched hand in the hand frame, with
/// their standard deviations; with `average_scale` those of a hand of this shape and the average
/// size. Source and thickness are the caller's.
HandModel hand_of_figure(const FigureEstimate& figure, Layout layout,
                         bool average_scale = false) noexcept;

}  // namespace handyar
