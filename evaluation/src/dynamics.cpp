// SPDX-License-Identifier: MIT
#include "handyar/evaluation/dynamics.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "handyar/evaluation/rigid.hpp"

namespace handyar::evaluation {
namespace {

constexpr double kLever_m = 0.1;   ///< makes rotation and translation comparable
constexpr double kStill_m = 1e-3;  ///< a step between frames below this is still
constexpr int kLeastStillFrames = 8;
constexpr std::size_t kStepFrames = 5;        ///< over which displacements are taken for the delay
constexpr int kLeastLag = -5, kMostLag = 10;  ///< frames
constexpr double kMoving_m = 3e-3;            ///< rms displacement above which a delay can be told
constexpr int kLeastSteps = 30;
constexpr int kShortGlimpseFrames =
    12;  ///< in view no longer than this: not held against a tracker

/// Three points of the hand in the camera frame, one a column.
Eigen::Matrix3d points(const Eigen::Isometry3d& T_camera_hand) {
  Eigen::Matrix3d p;
  p << Eigen::Vector3d::Zero(), kLever_m * Eigen::Vector3d::UnitX(),
      kLever_m * Eigen::Vector3d::UnitY();
  return (T_camera_hand.linear() * p).colwise() + T_camera_hand.translation();
}

/// The true points at a frame number between frames.
Eigen::Matrix3d true_points(const Truth& truth, double frame) {
  const double at = std::clamp(frame, 0.0, double(truth.frames.size() - 1));
  const std::size_t i = std::size_t(at), j = std::min(i + 1, truth.frames.size() - 1);
  const double s = at - double(i);
  return (1 - s) * points(truth.frames[i].T_camera_hand) +
         s * points(truth.frames[j].T_camera_hand);
}

/// The largest way that one of the points goes in the `frames` before frame i.
double true_step_m(const Truth& truth, std::size_t i, std::size_t frames) {
  return (true_points(truth, double(i)) - true_points(truth, double(i - frames)))
      .colwise()
      .norm()
      .maxCoeff();
}

/// Sum of squared deviations from the mean of one still run.
void add_run(const Truth& truth, const Poses& poses, std::size_t begin, std::size_t end,
             Jitter& jitter, double& translation_sum, double& rotation_sum) {
  const int n = int(end - begin);
  if (n < kLeastStillFrames) return;
  Eigen::Matrix3Xd t(3, n), w(3, n);
  for (int k = 0; k < n; ++k) {
    const Eigen::Isometry3d& T = *poses[begin + std::size_t(k)];
    const Eigen::Isometry3d& T_true = truth.frames[begin + std::size_t(k)].T_camera_hand;
    t.col(k) = T.translation() - T_true.translation();
    w.col(k) = rotation_vector(T.linear() * T_true.linear().transpose());
  }
  translation_sum += (t.colwise() - t.rowwise().mean()).squaredNorm();
  rotation_sum += (w.colwise() - w.rowwise().mean()).squaredNorm();
  jitter.frames += n;
}

struct Steps {
  std::vector<std::size_t> at;  ///< frame at the end of the step
  std::vector<Eigen::Matrix3d> estimated;
};

double correlation(const Truth& truth, const Steps& steps, double lag_frames) {
  double both = 0, estimated = 0, real = 0;
  for (std::size_t k = 0; k < steps.at.size(); ++k) {
    const double i = double(steps.at[k]) - lag_frames;
    const Eigen::Matrix3d d = true_points(truth, i) - true_points(truth, i - double(kStepFrames));
    both += d.cwiseProduct(steps.estimated[k]).sum();
    estimated += steps.estimated[k].squaredNorm();
    real += d.squaredNorm();
  }
  return both / std::sqrt(std::max(estimated * real, 1e-300));
}

}  // namespace

Poses right_poses(const Truth& truth, const HandModel& hand, std::span<const TrackResult> track,
                  std::span<const FrameError> errors, bool filtered) {
  const TrueHand true_hand(truth, hand);
  Poses poses(std::min(track.size(), truth.frames.size()));
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!errors[i].right() || !errors[i].visible) continue;
    const auto lay = [&](const auto& pose) {
      if (pose) poses[i] = true_hand.T_camera_hand(truth.frames[i], pose->T_camera_hand);
    };
    filtered ? lay(track[i].pose) : lay(track[i].raw_pose);
  }
  return poses;
}

Jitter jitter(const Truth& truth, const Poses& poses) {
  Jitter j;
  double translation_sum = 0, rotation_sum = 0;
  std::size_t begin = 0;
  for (std::size_t i = 0; i <= poses.size(); ++i) {
    const bool goes_on =
        i < poses.size() && poses[i] && (i == 0 || true_step_m(truth, i, 1) < kStill_m);
    if (goes_on) continue;
    if (begin < i) add_run(truth, poses, begin, i, j, translation_sum, rotation_sum);
    begin = i < poses.size() && poses[i] ? i : i + 1;
  }
  if (j.frames > 0) {
    j.translation_mm = 1e3 * std::sqrt(translation_sum / j.frames);
    j.rotation_deg = 180 / std::numbers::pi * std::sqrt(rotation_sum / j.frames);
  }
  return j;
}

std::optional<double> delay_s(const Truth& truth, const Poses& poses) {
  Steps steps;
  double moved = 0;
  const std::size_t ahead = std::size_t(-kLeastLag);
  const std::size_t after = poses.size() > ahead ? poses.size() - ahead : 0;
  // Only where truth is known at every lag, so that all lags are tried on the same frames.
  for (std::size_t i = kStepFrames + kMostLag; i < after; ++i) {
    const std::size_t before = i - kStepFrames;
    if (!poses[i] || !poses[before]) continue;
    if (truth.frames[i].other_face != truth.frames[before].other_face) continue;
    steps.at.push_back(i);
    steps.estimated.push_back(points(*poses[i]) - points(*poses[before]));
    moved += std::pow(true_step_m(truth, i, kStepFrames), 2);
  }
  if (steps.at.size() < kLeastSteps || std::sqrt(moved / double(steps.at.size())) < kMoving_m)
    return std::nullopt;

  // Linear interpolation of truth is exact at whole frames only: the correlation is taken there and
  // its maximum placed by the parabola through the three highest values.
  std::vector<double> c;
  for (int lag = kLeastLag; lag <= kMostLag; ++lag) c.push_back(correlation(truth, steps, lag));
  const std::size_t best = std::size_t(std::max_element(c.begin(), c.end()) - c.begin());
  double lag = double(best) + kLeastLag;
  if (best > 0 && best + 1 < c.size()) {
    const double curve = c[best - 1] - 2 * c[best] + c[best + 1];
    if (curve < 0) lag += 0.5 * (c[best - 1] - c[best + 1]) / curve;
  }
  return lag / truth.frames_per_second;
}

std::vector<Recovery> recoveries(const Truth& truth, std::span<const FrameError> errors) {
  std::vector<Recovery> all;
  const std::size_t n = std::min(errors.size(), truth.frames.size());
  bool ever = false;
  for (std::size_t i = 0; i < n; ++i) {
    const bool appears = errors[i].visible && (i == 0 || !errors[i - 1].visible);
    const bool lost = i > 0 && errors[i].visible && errors[i - 1].visible &&
                      errors[i - 1].right() && !errors[i].right();
    if (!appears && !lost) continue;
    std::size_t end = i;
    while (end < n && errors[end].visible && !errors[end].right()) ++end;
    const bool found = end < n && errors[end].visible;
    if (!found && int(end - i) <= kShortGlimpseFrames) continue;
    Recovery r{Recovery::Kind::hidden_before, int(i), std::nullopt};
    if (lost) r.kind = Recovery::Kind::lost_in_view;
    if (!ever) r.kind = Recovery::Kind::first_sight;
    if (found) r.after_s = double(end - i) / truth.frames_per_second;
    ever = true;
    all.push_back(r);
  }
  return all;
}

}  // namespace handyar::evaluation
