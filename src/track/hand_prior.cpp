// SPDX-License-Identifier: MIT
#include "track/hand_prior.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace handyar {

HandPrior prior_around(const HandState& expected, const Person& person, double dt_s,
                       const TrackerConfig& config) noexcept {
  const MotionConfig& motion = config.motion;
  HandPrior prior;
  prior.mean = expected;
  constexpr double kShortest_s = 1e-3;  // no information is infinite
  const double keeps = std::exp(-std::max(dt_s, kShortest_s) / motion.posture_s),
               moves = std::sqrt(1 - keeps * keeps);
  for (double& angle_rad : prior.mean.posture.abduction_rad) angle_rad *= keeps;
  for (double& angle_rad : prior.mean.posture.flexion_rad) angle_rad *= keeps;
  prior.mean.figure = person.mean();
  HandVector sigma = HandVector::Ones();
  sigma.head<3>().setConstant(motion.rotation_sigma_rad);
  sigma.segment<3>(3).setConstant(motion.translation_sigma_m);
  sigma.segment<kFingerCount>(kAbductionAt).setConstant(moves * motion.finger_sigma_rad);
  sigma.segment<kFingerCount>(kFlexionAt).setConstant(moves * motion.finger_sigma_rad);
  sigma[kAbductionAt] = sigma[kFlexionAt] = moves * motion.thumb_sigma_rad;
  sigma[kBoundaryAt] = motion.boundary_sigma_px;
  prior.information = sigma.array().square().inverse().matrix().asDiagonal();
  // Besides turning each for itself, fingers close and open together.
  using Abductions = Eigen::Matrix<double, kFingerCount, 1>;
  const Abductions together =
      moves * motion.closing_sigma * Eigen::Map<const Abductions>(kClosing_rad.data());
  Eigen::Matrix<double, kFingerCount, kFingerCount> abduction = together * together.transpose();
  abduction.diagonal() += sigma.segment<kFingerCount>(kAbductionAt).array().square().matrix();
  prior.information.block<kFingerCount, kFingerCount>(kAbductionAt, kAbductionAt) =
      abduction.llt().solve(Eigen::Matrix<double, kFingerCount, kFingerCount>::Identity());
  prior.information.bottomRightCorner<kFigureModes, kFigureModes>() = person.information();
  return prior;
}

}  // namespace handyar
