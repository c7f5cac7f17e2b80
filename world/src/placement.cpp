// SPDX-License-Identifier: MIT
#include "handyar/world/placement.hpp"

#include <algorithm>
#include <cmath>

namespace handyar::world {
namespace {

using Ground = Eigen::Hyperplane<double, 3>;

double along_ground_m(const Ground& ground, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return (ground.projection(a) - ground.projection(b)).norm();
}

/// Upright on the ground, turned as it was.
Eigen::Matrix3d upright(const Ground& ground, const Eigen::Matrix3d& R) {
  Eigen::Matrix3d U;
  U.col(2) = ground.normal();
  const Eigen::Vector3d front = R.col(0) - ground.normal().dot(R.col(0)) * ground.normal();
  U.col(0) = front.norm() > 0.1 ? front.normalized() : ground.normal().unitOrthogonal();
  U.col(1) = U.col(2).cross(U.col(0));
  return U;
}

}  // namespace

std::string_view name(PlacementEvent event) noexcept {
  return event == PlacementEvent::picked_up ? "picked_up" : "put_down";
}

bool Placement::at_object(const Ground& ground, const Eigen::Vector3d& palm,
                          double within_m) const {
  const double up_m =
      ground.signedDistance(palm) - ground.signedDistance(T_world_object_.translation());
  return along_ground_m(ground, palm, T_world_object_.translation()) < within_m &&
         std::abs(up_m) < config_.above_m;
}

std::optional<PlacementEvent> Placement::update(
    double time_s, const Ground& ground, const std::optional<Eigen::Isometry3d>& T_world_stand) {
  const double step_s = started_ ? std::max(0.0, time_s - last_s_) : 0;
  if (!started_) hand_s_ = since_s_ = time_s;
  started_ = true;
  last_s_ = time_s;
  if (T_world_stand) hand_s_ = time_s;
  const bool gone = time_s - hand_s_ > config_.grace_s;

  if (carried_) {
    if (T_world_stand) carry(time_s, ground, *T_world_stand);
    const bool lies = T_world_stand &&
                      ground.signedDistance(T_world_stand->translation()) < config_.ground_m &&
                      time_s - since_s_ > config_.rest_s;
    if (!gone && !lies) return std::nullopt;
    carried_ = false;
    must_leave_ = true;
    return PlacementEvent::put_down;
  }

  stand(step_s, ground, T_world_stand);
  if (!T_world_stand) {
    since_s_ = time_s;
    return std::nullopt;
  }
  const Eigen::Vector3d palm = T_world_stand->translation();
  must_leave_ = must_leave_ && at_object(ground, palm, config_.away_m);
  if (must_leave_ || !at_object(ground, palm, config_.near_m)) since_s_ = time_s;
  if (time_s - since_s_ < config_.dwell_s) return std::nullopt;
  carried_ = true;
  since_s_ = time_s;
  resting_ = palm;
  // It goes over to the middle of the palm, turned as it stands.
  T_stand_object_.linear() =
      upright(Ground(Eigen::Vector3d::UnitZ(), 0.0),
              T_world_stand->linear().transpose() * T_world_object_.linear());
  T_stand_object_.translation() = T_world_stand->inverse() * T_world_object_.translation();
  return PlacementEvent::picked_up;
}

void Placement::carry(double time_s, const Ground& ground, const Eigen::Isometry3d& T_world_stand) {
  constexpr double kComesOver = 0.85;  // of what is left, a frame
  T_stand_object_.translation() *= kComesOver;
  T_world_object_ = T_world_stand * T_stand_object_;
  const Eigen::Vector3d palm = T_world_stand.translation();
  const bool low = ground.signedDistance(palm) < config_.ground_m;
  if (low && (palm - resting_).norm() < config_.rest_m) return;
  resting_ = palm;
  since_s_ = time_s;
}

// On a hand that lies under it, else on the ground.
void Placement::stand(double step_s, const Ground& ground,
                      const std::optional<Eigen::Isometry3d>& T_world_stand) {
  Eigen::Vector3d foot = T_world_object_.translation();
  double floor_m = 0;
  if (must_leave_ && T_world_stand &&
      at_object(ground, T_world_stand->translation(), config_.near_m))
    floor_m = std::max(0.0, ground.signedDistance(T_world_stand->translation()));
  const double height_m = ground.signedDistance(foot);
  const double most_m = config_.sink_m_s * step_s;
  foot += std::clamp(floor_m - height_m, -most_m, most_m) * ground.normal();
  T_world_object_.translation() = foot;
  const Eigen::Quaterniond now(T_world_object_.linear()),
      then(upright(ground, T_world_object_.linear()));
  T_world_object_.linear() = now.slerp(std::min(1.0, 6 * step_s), then).toRotationMatrix();
}

}  // namespace handyar::world
