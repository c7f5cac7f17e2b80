// SPDX-License-Identifier: MIT
#include "track/person.hpp"

#include <Eigen/Cholesky>
#include <limits>

namespace handyar {

Person::Person(const HandModel& hand) {
  const FigureEstimate known = estimate_figure(hand);
  mean_ = known.mean;
  information_ = known.covariance.llt().solve(Information::Identity());
  if (hand.source == HandSource::checkerboard || hand.source == HandSource::truth)
    rest_views_ = std::numeric_limits<double>::infinity();
}

FigureEstimate Person::estimate() const noexcept {
  return {mean_, information_.llt().solve(Information::Identity())};
}

void Person::learn(const Alignment& alignment, const HandPrior& rest, double share) noexcept {
  // What the frames before foretold of the posture was foretold with this figure and is no evidence
  // for it: in its place stands how hands are held at rest.
  const HandPrior& prior = alignment.prior;
  const HandMatrix H = alignment.information + rest.information - prior.information;
  const HandVector g = rest.information * alignment.state.difference(rest.mean) -
                       prior.information * alignment.state.difference(prior.mean);
  // The frame's own information of the figure, pose and posture marginalised out (Schur).
  const Eigen::Matrix<double, kFigureAt, kFigureModes> Hpf =
      H.topRightCorner<kFigureAt, kFigureModes>();
  const Eigen::Matrix<double, kFigureAt, kFigureModes> fixed =
      H.topLeftCorner<kFigureAt, kFigureAt>().llt().solve(Hpf);
  const Information posterior =
      H.bottomRightCorner<kFigureModes, kFigureModes>() - Hpf.transpose() * fixed;
  const FigureCoefficients pull = g.tail<kFigureModes>() - fixed.transpose() * g.head<kFigureAt>();
  // The aligned figure is the mean of prior and frame: so much of the way is the frame's.
  const Information learned = information_ + share * (posterior - information_);
  const FigureCoefficients step =
      learned.llt().solve(share * (posterior * (alignment.state.figure - mean_) + pull));
  if (!step.allFinite() || !learned.allFinite()) return;
  mean_ += step;
  information_ = 0.5 * (learned + learned.transpose());
  rest_views_ += share;
  rest_ = rest_.towards(alignment.state.posture, share / rest_views_);
}

}  // namespace handyar
