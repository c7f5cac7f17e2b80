// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "handyar/stages/align.hpp"
#include "handyar/stages/hand_figure.hpp"

namespace handyar {

/// What is known of the person, learned from frame to frame: the figure, a Gaussian in information
/// form, and how the fingers are held at rest.
class Person {
 public:
  using Information = Eigen::Matrix<double, kFigureModes, kFigureModes>;

  Person() = default;  ///< anybody
  /// Fingertips that were measured tell the rest, too: it is the figure's.
  explicit Person(const HandModel& hand);

  const FigureCoefficients& mean() const { return mean_; }
  const Information& information() const { return information_; }
  const Posture& rest() const { return rest_; }

  FigureEstimate estimate() const noexcept;

  /// Takes what an aligned frame says of the figure, whatever its pose and its posture but for how
  /// the hand is held at `rest`, and that it is held so, `share` of both: neighbouring frames say
  /// the same.
  void learn(const Alignment& alignment, const HandPrior& rest, double share) noexcept;

 private:
  FigureCoefficients mean_ = FigureCoefficients::Zero();
  Information information_ = Information::Identity();
  Posture rest_;
  double rest_views_ = 1;  ///< that it is the mean of; the first is of people at large
};

}  // namespace handyar
