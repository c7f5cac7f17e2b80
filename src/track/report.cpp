// SPDX-License-Identifier: MIT
#include <Eigen/Cholesky>

#include "align/silhouette.hpp"
#include "track/tracker_state.hpp"

namespace handyar {
namespace {

bool inside(const Eigen::Vector2d& px, const Camera& camera) {
  return px.x() >= -0.5 && px.y() >= -0.5 && px.x() < camera.width_px - 0.5 &&
         px.y() < camera.height_px - 0.5;
}

/// Where a point of the hand lies in the frame.
Tip shown(const Eigen::Vector3d& p_hand, const Eigen::Isometry3d& T_camera_hand,
          const Camera& camera) {
  const Eigen::Vector3d p = T_camera_hand * p_hand;
  Tip tip;
  if (p.z() < kNearest_m) return tip;
  tip.px = camera.project(p);
  tip.seen = inside(tip.px, camera);
  tip.inferred = !tip.seen;
  return tip;
}

}  // namespace

void HandTracker::Impl::report(TrackResult& result) noexcept {
  result.state = seen.state;
  result.gesture = seen.gestures.gesture();
  result.gesture_event = seen.gestures.event();
  evidence = {};
  evidence.candidates = candidates;
  evidence.belief = seen.belief;
  evidence.hypotheses = seen.hypotheses.size();
  if (const Hypothesis* seen_hand = in_view()) {
    result.layout = seen_hand->appearance.layout;
    result.face = seen_hand->appearance.face;
  }
  if (seen.hypotheses.size() == 0) return;
  const Hypothesis& best = seen.hypotheses.best();
  const HandState& state = best.alignment.state;
  evidence.outline = outline;
  evidence.log_ratio = best.alignment.log_ratio;
  const PosedFigure posed = posed_figure(best.appearance, state);
  for (int f = 0; f < kFingerCount; ++f)
    result.tips[f] = shown(posed.tips_m.col(f), state.T_camera_hand, camera);
  for (int k = 0; k < kValleyCount; ++k)
    result.webs[k] = shown(posed.centres_m.col(kFirstWeb + k), state.T_camera_hand, camera);
  const HandVector sigma = best.alignment.information.llt()
                               .solve(HandMatrix::Identity())
                               .diagonal()
                               .cwiseMax(0)
                               .cwiseSqrt();
  for (int f = 0; f < kFingerCount; ++f)
    result.fingers[f] = {state.posture.abduction_rad[f], sigma[kAbductionAt + f],
                         state.posture.flexion_rad[f], sigma[kFlexionAt + f]};
  result.thumb_bend_rad = state.posture.thumb_bend_rad;
  if (seen.state != State::tracking) {
    result.raw_pose.reset();
    result.pose.reset();
  } else {
    // What stands on a hand that is read otherwise goes there unseen, not in a leap; and a frame
    // that says no by as much as hands are given up for shows a figure that leaps.
    result.doubtful = seen.lately < config.belief.doubt() || !result.pose ||
                      config.belief.says(best.alignment.log_ratio) < config.belief.give_up() ||
                      seen.time_s - seen.changed_s < config.belief.same_s ||
                      sigma_rotation_rad(result.pose->covariance) > config.belief.doubt_rad;
  }
}

Posture posture_of(const TrackResult& result) noexcept {
  Posture posture;
  for (int f = 0; f < kFingerCount; ++f) {
    posture.abduction_rad[f] = result.fingers[f].abduction_rad;
    posture.flexion_rad[f] = result.fingers[f].flexion_rad;
  }
  posture.thumb_bend_rad = result.thumb_bend_rad;
  return posture;
}

}  // namespace handyar
