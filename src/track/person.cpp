// SPDX-License-Identifier: MIT
#include "track/person.hpp"

#include <Eigen/Cholesky>

namespace handyar {

Person::Person(const FigureEstimate& known)
    : mean_(known.mean), information_(known.covariance.llt().solve(Information::Identity())) {}

FigureEstimate Person::estimate() const noexcept {
  return {mean_, information_.llt().solve(Information::Identity())};
}

void Person::learn(const Alignment& alignment, double share) noexcept {
  // The frame's own information of the figure, pose and posture marginalised out (Schur).
  const HandMatrix& H = alignment.information;
  const auto Hpp = H.topLeftCorner<kFigureAt, kFigureAt>();
  const Eigen::Matrix<double, kFigureAt, kFigureModes> Hpf =
      H.topRightCorner<kFigureAt, kFigureModes>();
  const Information posterior =
      H.bottomRightCorner<kFigureModes, kFigureModes>() - Hpf.transpose() * Hpp.llt().solve(Hpf);
  // The aligned figure is the mean of prior and frame: so much of the way is the frame's.
  const Information learned = information_ + share * (posterior - information_);
  const FigureCoefficients step =
      learned.llt().solve(share * posterior * (alignment.state.figure - mean_));
  if (!step.allFinite() || !learned.allFinite()) return;
  mean_ += step;
  information_ = 0.5 * (learned + learned.transpose());
}

}  // namespace handyar
