// SPDX-License-Identifier: MIT
#include "handyar/calibration/self_calibration.hpp"

#include <cmath>
#include <numbers>

#include "handyar/calibration/camera_calibration.hpp"
#include "handyar/stages/hand_figure.hpp"
#include "text.hpp"

namespace handyar {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
// A shape that still changes by more than this (root mean square over the fingertips, in the hand
// plane) after half of the views was not found.
constexpr double kMostChange_m = 0.004;
constexpr double kLeastTurn_rad = 30 * kDegree;
constexpr double kMostCoefficient = 8;  // a hand file with a figure beyond is refused

/// Factor that gives the figure of a view its size.
double size_factor(const CalibrationView& view, const KnownLength& known) {
  const HandFigure figure = make_figure(view.hand.figure->mean, Face::palm, view.hand.layout);
  if (known.hand_length_m) return *known.hand_length_m / hand_length_m(figure);
  if (!known.span_m) return 1;
  const auto tips_m = pose_fingers(figure, view.posture).tips_m;  // not at rest: as it was spread
  return *known.span_m / (tips_m.col(0) - tips_m.col(kFingerCount - 1)).norm();
}

/// How far the fingertips of two shapes of one size lie apart.
double change_m(const HandModel& a, const HandModel& b) {
  const double factor = b.span_m() / a.span_m();
  const HandModel same = a.for_layout(b.layout);
  return std::sqrt((factor * same.tips_m - b.tips_m).topRows<2>().squaredNorm() / kFingerCount);
}

}  // namespace

SelfCalibration self_calibrate_hand(std::span<const CalibrationView> views, const Camera& camera,
                                    const KnownLength& known) {
  std::vector<Viewpoint> viewpoints;
  std::vector<const CalibrationView*> used;
  for (const CalibrationView& view : views) {
    if (!view.hand_seen() || !view.T_camera_hand || !view.hand.figure) continue;
    used.push_back(&view);
    viewpoints.push_back(viewpoint(*view.T_camera_hand, view.hand.palm_centre_m(),
                                   Eigen::Vector3d::UnitZ(), camera));
  }
  if (std::ssize(used) < kMinViews)
    throw CalibrationError(
        text("five fingertips are seen in %zu of %zu frames, %d are needed: "
             "show the open hand, fingers spread",
             used.size(), views.size(), kMinViews));
  SelfCalibration out;
  out.views = static_cast<int>(used.size());
  out.turned_rad = directions_span_rad(viewpoints);
  if (out.turned_rad < kLeastTurn_rad)
    throw CalibrationError(
        text("the hand was seen from one side only, directions differ by %.0f "
             "degrees: turn it left, right, up and down by 30 degrees",
             out.turned_rad / kDegree));
  const HandModel& learned = used.back()->hand;
  const double changed_m = change_m(used[used.size() / 2]->hand, learned);
  if (changed_m > kMostChange_m)
    throw CalibrationError(
        text("the two halves of the views tell different hands, their fingertips lie %.0f mm "
             "apart: hold the hand stiff, fingers spread, and turn it as a whole for longer",
             1000 * changed_m));
  const FigureEstimate sized = rescaled(*learned.figure, size_factor(*used.back(), known));
  out.hand = hand_of_figure(sized, learned.layout, !known.span_m && !known.hand_length_m);
  if (sized.mean.cwiseAbs().maxCoeff() > kMostCoefficient)
    throw CalibrationError(
        text("the hand would measure %.0f mm from thumb tip to little fingertip, which none does: "
             "measure the length again",
             1000 * out.hand.span_m()));
  out.hand.source = HandSource::self;
  return out;
}

}  // namespace handyar
