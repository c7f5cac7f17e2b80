// SPDX-License-Identifier: MIT
#include "track/hand_prior.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace handyar {

HandPrior prior_around(const HandState& expected, const Person& person, double dt_s,
                       const TrackerConfig& config, double liveliness) noexcept {
  const MotionConfig& motion = config.motion;
  HandPrior prior;
  prior.mean = expected;
  constexpr double kShortest_s = 1e-3;  // no information is infinite
  const double keeps = std::exp(-std::max(dt_s, kShortest_s) / config.belief.same_s),
               moves = liveliness * std::sqrt(1 - keeps * keeps);
  prior.mean.posture = person.rest().towards(expected.posture, keeps);
  prior.mean.figure = person.mean();
  HandVector sigma = HandVector::Ones();
  sigma.head<3>().setConstant(motion.rotation_sigma_rad);
  sigma.segment<3>(3).setConstant(motion.translation_sigma_m);
  for (int f = 0; f < kFingerCount; ++f) sigma[kFlexionAt + f] = moves * finger_sigma_rad(f);
  sigma[kThumbBendAt] = moves * finger_sigma_rad(0);
  sigma[kBoundaryAt] = motion.boundary_sigma_px;
  prior.information = sigma.array().square().inverse().matrix().asDiagonal();
  const Eigen::Matrix<double, kFingerCount, kFingerCount> abduction =
      moves * moves * abduction_covariance_rad2();
  prior.information.block<kFingerCount, kFingerCount>(kAbductionAt, kAbductionAt) =
      abduction.llt().solve(Eigen::Matrix<double, kFingerCount, kFingerCount>::Identity());
  prior.information.bottomRightCorner<kFigureModes, kFigureModes>() = person.information();
  return prior;
}

double liveliness_after(double dt_s, const Posture& found, const Posture& rest, double before,
                        double same_s) noexcept {
  // Angles that are drawn to rest by a prior of variance v and measured with the variance n have a
  // variance of at most v / 4 where there is no motion, whatever n is: with four times what is
  // found v shrinks for a hand at rest, and for one that moves by more than n it does not.
  constexpr double kUnshrunk = 4;
  double found_variance = 0;
  for (int f = 0; f < kFingerCount; ++f) {
    const double sigma_rad = finger_sigma_rad(f);
    const double turned_rad = found.abduction_rad[f] - rest.abduction_rad[f],
                 bent_rad = found.flexion_rad[f] - rest.flexion_rad[f];
    found_variance += (turned_rad * turned_rad + bent_rad * bent_rad) /
                      (2 * kFingerCount * sigma_rad * sigma_rad);
  }
  // It rises at once, since fingers that close would pull the palm with them.
  const double now = kUnshrunk * found_variance, keeps = std::exp(-dt_s / same_s);
  const double variance = std::max(now, keeps * before * before + (1 - keeps) * now);
  return std::clamp(std::sqrt(variance), kStillest, 1.0);
}

}  // namespace handyar
