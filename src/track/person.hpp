// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "handyar/stages/align.hpp"
#include "handyar/stages/hand_figure.hpp"

namespace handyar {

/// What is known of the person's figure: a Gaussian in information form, learned from frame to
/// frame.
class Person {
 public:
  using Information = Eigen::Matrix<double, kFigureModes, kFigureModes>;

  Person() = default;  ///< anybody
  explicit Person(const FigureEstimate& known);

  const FigureCoefficients& mean() const { return mean_; }
  const Information& information() const { return information_; }

  FigureEstimate estimate() const noexcept;

  /// Takes what an aligned frame says of the figure, whatever its pose and its posture but for how
  /// hands are held at `rest`, `share` of it: neighbouring frames say the same.
  void learn(const Alignment& alignment, const HandPrior& rest, double share) noexcept;

 private:
  FigureCoefficients mean_ = FigureCoefficients::Zero();
  Information information_ = Information::Identity();
};

}  // namespace handyar
