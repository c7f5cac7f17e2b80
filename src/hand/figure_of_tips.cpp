// SPDX-License-Identifier: MIT
// What fingertips tell of a person's figure.
#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "hand/figure_statistics.hpp"

namespace handyar {
namespace {

/// What fingertips in the hand plane tell: the figure, the five abductions, and by how much the
/// frame in which they were measured is turned in the hand plane.
constexpr int kTipPlaces = 2 * kFingerCount, kTurnAt = kFigureModes + kFingerCount,
              kHeldFreedoms = kTurnAt + 1;
using TipPlaces = Eigen::Matrix<double, kTipPlaces, 1>;
using TipMatrix = Eigen::Matrix<double, kTipPlaces, kTipPlaces>;
using Held = Eigen::Matrix<double, kHeldFreedoms, 1>;
using HeldMatrix = Eigen::Matrix<double, kHeldFreedoms, kHeldFreedoms>;
using HeldDerivative = Eigen::Matrix<double, kTipPlaces, kHeldFreedoms>;

Eigen::Vector2d quarter_turn(const Eigen::Vector2d& v) { return {-v.y(), v.x()}; }

/// What is known of them before; what else of the posture, abductions aside, is known for certain.
struct HeldPrior {
  Held mean = Held::Zero();
  HeldMatrix covariance = HeldMatrix::Zero();
  Posture posture;
};

/// Fingertips of a palm in thumb_right, in the frame that HandModel says, and by what they change.
TipPlaces tips_of(const Held& held, Posture posture, HeldDerivative& J) {
  for (int f = 0; f < kFingerCount; ++f) posture.abduction_rad[f] = held[kFigureModes + f];
  const PosedFigure posed = pose_fingers(
      make_figure(held.head<kFigureModes>(), Face::palm, Layout::thumb_right), posture);
  const Eigen::Matrix2d R = Eigen::Rotation2Dd(held[kTurnAt]).toRotationMatrix();
  TipPlaces places;
  J.setZero();
  for (int f = 0; f < kFingerCount; ++f) {
    const Eigen::Vector2d tip = posed.tips_m.col(f).head<2>(),
                          root = posed.centres_m.col(sphere_of(f, 0)).head<2>();
    places.segment<2>(2 * f) = R * tip;
    for (int k = 0; k < kFigureModes; ++k) {
      const float* mode = kFigureModes_m[k] + kTipOffset + 3 * f;
      J.block<2, 1>(2 * f, k) = R * Eigen::Vector2d(mode[0], mode[1]);
    }
    J.block<2, 1>(2 * f, kFigureModes + f) = -R * quarter_turn(tip - root);  // towards the thumb
    J.block<2, 1>(2 * f, kTurnAt) = quarter_turn(R * tip);
  }
  constexpr int kX = 2 * static_cast<int>(Finger::middle),
                kY = 2 * static_cast<int>(Finger::thumb) + 1;
  const Eigen::Vector2d origin(places[kX], places[kY]);
  Eigen::Matrix<double, 2, kHeldFreedoms> of_origin;
  of_origin << J.row(kX), J.row(kY);
  for (int f = 0; f < kFingerCount; ++f) {
    places.segment<2>(2 * f) -= origin;
    J.middleRows<2>(2 * f) -= of_origin;
  }
  return places;
}

struct FigureOfTips {
  FigureEstimate figure;
  double log_likelihood = 0;  ///< of the fingertips, nats
};

struct MeasuredTips {
  TipPlaces places_m, variance_m2;

  explicit MeasuredTips(const HandModel& hand) {
    const HandModel seen = hand.for_layout(Layout::thumb_right);
    // Tips that say nothing of their doubt were measured to about a millimetre; a hand whose scale
    // is assumed still tells the shape. Heights over the hand plane change sign with the face,
    // which a model does not tell.
    constexpr double kMeasured_m = 0.001;
    for (int i = 0; i < kTipPlaces; ++i) {
      const int f = i / 2, axis = i % 2;
      const double stated_m = std::max(seen.tips_sigma_m(axis, f), kMeasured_m),
                   unexplained_m = kFigureSigma_m[kTipOffset + 3 * f + axis];
      places_m[i] = seen.tips_m(axis, f);
      variance_m2[i] = stated_m * stated_m + unexplained_m * unexplained_m;
    }
  }
};

/// By fingertips, of a hand that is held with this prior (Gauss-Newton).
FigureOfTips figure_of_tips(const MeasuredTips& tips, const HeldPrior& prior) {
  constexpr int kSteps = 10;
  FigureOfTips result;
  Held held = prior.mean;
  for (int step = 0; step < kSteps; ++step) {
    HeldDerivative J;
    const TipPlaces places_m = tips_of(held, prior.posture, J),
                    off = tips.places_m - places_m + J * (held - prior.mean);
    const HeldDerivative by_prior = J * prior.covariance;
    TipMatrix S = by_prior * J.transpose();
    S.diagonal() += tips.variance_m2;
    const Eigen::LLT<TipMatrix> llt(S);
    const TipPlaces weighted = llt.solve(off);
    held = prior.mean + by_prior.transpose() * weighted;
    result.figure.mean = held.head<kFigureModes>();
    result.figure.covariance = (prior.covariance - by_prior.transpose() * llt.solve(by_prior))
                                   .topLeftCorner<kFigureModes, kFigureModes>();
    result.log_likelihood =
        -0.5 * off.dot(weighted) - llt.matrixLLT().diagonal().array().log().sum();
  }
  return result;
}

/// In the frame in which fingertips were measured the middle finger may lie so far from the hand's
/// own axis (standard deviation): they alone do not tell which way is along it.
constexpr double kTurned_rad = 0.35;

}  // namespace

FigureEstimate estimate_figure(const HandModel& hand) noexcept {
  if (hand.figure) return *hand.figure;
  if (hand.source == HandSource::average_adult) return {};
  const MeasuredTips tips(hand);
  // Fingers are held at rest or otherwise: the likeliest of these.
  FigureOfTips likeliest;
  likeliest.log_likelihood = -std::numeric_limits<double>::infinity();
  for (const double strays : {0.0, 1.0})
    for (const double turned_rad : {0.0, kTurned_rad}) {
      HeldPrior prior;
      prior.covariance.topLeftCorner<kFigureModes, kFigureModes>().setIdentity();
      prior.covariance.block<kFingerCount, kFingerCount>(kFigureModes, kFigureModes) =
          strays * abduction_covariance_rad2();
      prior.covariance(kTurnAt, kTurnAt) = turned_rad * turned_rad;
      const FigureOfTips told = figure_of_tips(tips, prior);
      if (told.log_likelihood > likeliest.log_likelihood) likeliest = told;
    }
  return likeliest.figure;
}

FigureEstimate estimate_figure(const HandModel& hand, const FigureEstimate& person,
                               const Posture& held) noexcept {
  HeldPrior prior;
  prior.posture = held;
  prior.mean.head<kFigureModes>() = person.mean;
  prior.covariance.topLeftCorner<kFigureModes, kFigureModes>() = person.covariance;
  for (int f = 0; f < kFingerCount; ++f) prior.mean[kFigureModes + f] = held.abduction_rad[f];
  prior.covariance(kTurnAt, kTurnAt) = kTurned_rad * kTurned_rad;
  return figure_of_tips(MeasuredTips(hand), prior).figure;
}

}  // namespace handyar
