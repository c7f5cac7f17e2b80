// SPDX-License-Identifier: MIT
#include <Eigen/Cholesky>
#include <algorithm>

#include "handyar/stages/align.hpp"
#include "pose/so3.hpp"

namespace handyar {

Eigen::Isometry3d HandState::pose_after(double dt_s) const noexcept {
  const double goes_on_s = std::min(dt_s, kLongest_s);
  Eigen::Isometry3d T = T_camera_hand;
  T.linear() = so3::exp(goes_on_s * velocity.head<3>()).toRotationMatrix() * T.linear();
  T.translation() += goes_on_s * velocity.tail<3>();
  return T;
}

PosedFigure posed_figure(Appearance appearance, const HandState& state) noexcept {
  return pose_fingers(make_figure(state.figure, appearance.face, appearance.layout), state.posture);
}

void HandState::correct(const HandVector& step) noexcept {
  T_camera_hand.linear() = so3::turned(step.head<3>(), T_camera_hand.linear());
  T_camera_hand.translation() += step.segment<3>(3);
  for (int f = 0; f < kFingerCount; ++f) {
    posture.abduction_rad[f] += step[kAbductionAt + f];
    posture.flexion_rad[f] += step[kFlexionAt + f];
  }
  posture.thumb_bend_rad += step[kThumbBendAt];
  boundary_px += step[kBoundaryAt];
  figure += step.tail<kFigureModes>();
}

HandVector HandState::difference(const HandState& other) const noexcept {
  HandVector d;
  d.head<3>() =
      so3::log(Eigen::Matrix3d(other.T_camera_hand.linear() * T_camera_hand.linear().transpose()));
  d.segment<3>(3) = other.T_camera_hand.translation() - T_camera_hand.translation();
  for (int f = 0; f < kFingerCount; ++f) {
    d[kAbductionAt + f] = other.posture.abduction_rad[f] - posture.abduction_rad[f];
    d[kFlexionAt + f] = other.posture.flexion_rad[f] - posture.flexion_rad[f];
  }
  d[kThumbBendAt] = other.posture.thumb_bend_rad - posture.thumb_bend_rad;
  d[kBoundaryAt] = other.boundary_px - boundary_px;
  d.tail<kFigureModes>() = other.figure - figure;
  return d;
}

Matrix6d pose_information(const HandMatrix& information) noexcept {
  constexpr int kRest = kHandFreedoms - 6;
  const Eigen::Matrix<double, kRest, kRest> rest = information.bottomRightCorner<kRest, kRest>();
  const Eigen::Matrix<double, 6, kRest> cross = information.topRightCorner<6, kRest>();
  return information.topLeftCorner<6, 6>() - cross * rest.llt().solve(cross.transpose());
}

}  // namespace handyar
