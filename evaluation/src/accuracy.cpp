// SPDX-License-Identifier: MIT
#include "handyar/evaluation/accuracy.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "handyar/evaluation/board_error.hpp"
#include "handyar/evaluation/rigid.hpp"

namespace handyar::evaluation {
namespace {

constexpr double kChiSquare6At95 = 12.5916;
constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kMillimetres = 1e3;

PoseError pose_error(const Eigen::Isometry3d& estimate, const Matrix6d& covariance,
                     const Eigen::Isometry3d& truth) {
  PoseError e;
  e.rotation_deg = angle_between(estimate.linear(), truth.linear()) * kDegrees;
  Eigen::Vector<double, 6> error;
  error << rotation_vector(truth.linear() * estimate.linear().transpose()),
      truth.translation() - estimate.translation();
  e.translation_mm = error.tail<3>().norm() * kMillimetres;
  e.translation_percent = 100 * error.tail<3>().norm() / truth.translation().norm();
  const Eigen::LLT<Matrix6d> llt(covariance);
  if (llt.info() == Eigen::Success) e.nees = error.dot(llt.solve(error));
  return e;
}

/// The hand frame of one face in that of the other.
Eigen::Isometry3d turned_about_y() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::Vector3d(-1, 1, -1).asDiagonal();
  return T;
}

double scale_to_truth(const Truth& truth, const HandModel& hand) {
  if (!hand.scale_assumed()) return 1;
  const auto size_m = [](const Eigen::Matrix3Xd& tips_m) {
    return (tips_m.colwise() - tips_m.rowwise().mean()).norm();
  };
  return size_m(truth.hand.tips_m) / size_m(hand.tips_m);
}

void compare_fingers(const TruthFrame& truth, const TrackResult& result, FrameError& e) {
  if (!truth.fingers) return;
  e.abduction_deg = e.flexion_deg = 0;
  for (std::size_t f = 0; f < kFingerCount; ++f) {
    const FingerState& finger = result.fingers[f];
    const TrueFinger& exact = (*truth.fingers)[f];
    e.abduction_deg += std::abs(finger.abduction_rad * kDegrees - exact.abduction_deg);
    e.flexion_deg += std::abs(finger.flexion_rad * kDegrees - exact.flexion_deg);
  }
  e.abduction_deg /= kFingerCount;
  e.flexion_deg /= kFingerCount;
}

class Comparison {
 public:
  Comparison(const Truth& truth, const HandModel& hand) : truth_(truth), true_hand_(truth, hand) {}

  FrameError operator()(const TruthFrame& f, const TrackResult& r) const {
    FrameError e;
    e.no_open_hand = f.no_open_hand;
    e.visible = f.all_tips_visible;
    e.tracked = r.state == State::tracking;
    e.layout_right = r.layout == f.layout;
    e.tilt_deg = f.tilt_rad() * kDegrees;
    e.distance_mm = f.distance_m() * kMillimetres;
    if (!e.tracked) return e;
    e.tips = tip_errors(r.tips, f.tips_px);
    e.on_other_hand =
        !e.tips.right() && f.other_tips_px && tip_errors(r.tips, *f.other_tips_px).right();
    e.wrong = !e.tips.right() && !e.on_other_hand;
    compare_fingers(f, r, e);
    if (r.raw_pose) {
      const Eigen::Isometry3d T = true_hand_.T_camera_hand(f, r.raw_pose->T_camera_hand);
      e.raw = pose_error(T, scaled(r.raw_pose->covariance), f.T_camera_hand);
      e.board_raw_px = board_px(f, T);
    }
    if (r.pose) {
      const Eigen::Isometry3d T = true_hand_.T_camera_hand(f, r.pose->T_camera_hand);
      e.filtered = pose_error(T, scaled(r.pose->covariance), f.T_camera_hand);
      e.board_filtered_px = board_px(f, T);
      const Eigen::Vector3d palm_m = truth_.hand.palm_centre_m();
      e.palm_px =
          (truth_.camera.project(T * palm_m) - truth_.camera.project(f.T_camera_hand * palm_m))
              .norm();
    }
    return e;
  }

 private:
  Matrix6d scaled(Matrix6d covariance) const {
    covariance.bottomRows<3>() *= true_hand_.scale();
    covariance.rightCols<3>() *= true_hand_.scale();
    return covariance;
  }

  double board_px(const TruthFrame& f, const Eigen::Isometry3d& T_camera_hand) const {
    if (!truth_.board || !truth_.hand_still_in_world) return kUnknown;
    const Eigen::Isometry3d T_camera_board = f.T_camera_world * *truth_.T_world_board;
    const Eigen::Isometry3d T_hand_board = f.T_camera_hand.inverse() * T_camera_board;
    return rms_distance_px(
        project_board(*truth_.board, truth_.camera, T_camera_hand * T_hand_board),
        project_board(*truth_.board, truth_.camera, T_camera_board));
  }

  const Truth& truth_;
  TrueHand true_hand_;
};

Summary summarize_counted(std::span<const FrameError> errors,
                          const std::function<double(const FrameError&)>& value) {
  std::vector<double> v;
  for (const FrameError& e : errors)
    if (e.counted()) v.push_back(value(e));
  return summarize(v);
}

double share_within(double limit, std::span<const FrameError> errors,
                    const std::function<double(const FrameError&)>& value) {
  int n = 0, within = 0;
  for (const FrameError& e : errors) {
    if (!e.counted() || std::isnan(value(e))) continue;
    ++n;
    within += value(e) <= limit;
  }
  return n ? double(within) / n : kUnknown;
}

}  // namespace

bool InView::add(bool seen, double time_s) {
  constexpr double kRounding_s = 2e-3;  // of the times of frames in files
  if (!seen)
    since_s_ = kUnknown;
  else if (std::isnan(since_s_))
    since_s_ = time_s;
  return time_s - since_s_ > kRegain_s - kRounding_s;
}

TipErrors tip_errors(const std::array<Tip, kFingerCount>& tips, const TipsPx& truth_px) {
  TipErrors e;
  e.span_px = (truth_px.front() - truth_px.back()).norm();
  for (std::size_t f = 0; f < kFingerCount; ++f)
    if (tips[f].known()) e.px[f] = (tips[f].px - truth_px[f]).norm();
  return e;
}

bool TipErrors::right() const {
  return std::all_of(px.begin(), px.end(),
                     [this](double error_px) { return error_px <= kWrongOfSpan * span_px; });
}

TrueHand::TrueHand(const Truth& truth, const HandModel& model)
    : scale_(scale_to_truth(truth, model)), T_model_hand_(Eigen::Isometry3d::Identity()) {
  if (model.source == HandSource::truth) return;
  const Eigen::Matrix3Xd tips_m = scale_ * model.for_layout(truth.hand.layout).tips_m;
  T_model_hand_ = rigid_fit(tips_m, truth.hand.tips_m).inverse();
}

Eigen::Isometry3d TrueHand::T_camera_hand(const TruthFrame& frame,
                                          Eigen::Isometry3d T_camera_model) const {
  T_camera_model.translation() *= scale_;
  const Eigen::Isometry3d turn =
      frame.other_face ? turned_about_y() : Eigen::Isometry3d::Identity();
  return T_camera_model * turn * T_model_hand_ * turn.inverse();
}

std::vector<FrameError> compare(const Truth& truth, const HandModel& hand,
                                std::span<const TrackResult> track) {
  const Comparison comparison(truth, hand);
  std::vector<FrameError> errors(track.size());
  InView in_view;
  for (std::size_t i = 0; i < std::min(track.size(), truth.frames.size()); ++i) {
    errors[i] = comparison(truth.frames[i], track[i]);
    const bool long_enough = in_view.add(errors[i].visible, track[i].time_s);
    errors[i].eligible = long_enough && int(i) >= kWarmUpFrames;
  }
  return errors;
}

Accuracy summarize(std::span<const FrameError> errors) {
  Accuracy a;
  std::vector<double> tip_px, tip_of_span;
  for (const FrameError& e : errors) {
    ++a.frames;
    a.no_open_hand += e.no_open_hand;
    a.falsely_tracked += e.no_open_hand && e.tracked && !e.on_other_hand;
    a.eligible += e.eligible;
    a.tracked += e.eligible && e.tracked;
    a.on_other_hand += e.eligible && e.on_other_hand;
    a.wrong += e.eligible && e.wrong;
    a.layout_wrong += e.eligible && e.tracked && !e.layout_right;
    if (!e.counted()) continue;
    for (double px : e.tips.px) {
      tip_px.push_back(px);
      tip_of_span.push_back(px / e.tips.span_px);
    }
  }
  a.tip_px = summarize(tip_px);
  a.tip_of_span = summarize(tip_of_span);
  for (std::size_t i = 0; i < kFingerCount; ++i)
    a.finger_px[i] = summarize_counted(errors, [i](const auto& e) { return e.tips.px[i]; });
  const auto over = [&](auto value) { return summarize_counted(errors, value); };
  a.rotation_deg = over([](const FrameError& e) { return e.filtered.rotation_deg; });
  a.rotation_raw_deg = over([](const FrameError& e) { return e.raw.rotation_deg; });
  a.translation_mm = over([](const FrameError& e) { return e.filtered.translation_mm; });
  a.translation_raw_mm = over([](const FrameError& e) { return e.raw.translation_mm; });
  a.translation_percent = over([](const FrameError& e) { return e.filtered.translation_percent; });
  a.board_px = over([](const FrameError& e) { return e.board_filtered_px; });
  a.board_raw_px = over([](const FrameError& e) { return e.board_raw_px; });
  a.abduction_deg = over([](const FrameError& e) { return e.abduction_deg; });
  a.flexion_deg = over([](const FrameError& e) { return e.flexion_deg; });
  a.nees = over([](const FrameError& e) { return e.filtered.nees; });
  a.nees_raw = over([](const FrameError& e) { return e.raw.nees; });
  const auto share = [&](double limit, auto value) { return share_within(limit, errors, value); };
  a.palm_px = over([](const FrameError& e) { return e.palm_px; });
  a.palm_within_8px = share(8, [](const FrameError& e) { return e.palm_px; });
  a.nees_within_95 = share(kChiSquare6At95, [](const FrameError& e) { return e.filtered.nees; });
  a.nees_raw_within_95 = share(kChiSquare6At95, [](const FrameError& e) { return e.raw.nees; });
  return a;
}

}  // namespace handyar::evaluation
