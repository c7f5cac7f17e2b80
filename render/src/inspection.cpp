// SPDX-License-Identifier: MIT
#include "handyar/render/inspection.hpp"

#include <algorithm>

namespace handyar::render {

std::string_view name(InspectionEvent event) noexcept {
  constexpr std::string_view kNames[] = {"selected", "attached", "released"};
  return kNames[static_cast<int>(event)];
}

std::optional<InspectionEvent> Inspection::look_for_choice(const InspectionInput& in) {
  const auto nearest = std::min_element(in.distance_px.begin(), in.distance_px.end());
  if (nearest == in.distance_px.end()) return std::nullopt;
  if (must_leave_) {
    must_leave_ = *nearest < config_.away_px;
    return std::nullopt;
  }
  const int at =
      *nearest <= config_.near_px ? static_cast<int>(nearest - in.distance_px.begin()) : -1;
  if (at != candidate_) {
    candidate_ = at;
    since_s_ = in.time_s;
  }
  if (candidate_ < 0 || in.time_s - since_s_ < config_.dwell_s) return std::nullopt;
  object_ = candidate_;
  candidate_ = -1;
  since_s_ = near_s_ = in.time_s;
  phase_ = InspectionPhase::selected;
  return InspectionEvent::selected;
}

std::optional<InspectionEvent> Inspection::update(const InspectionInput& in) {
  const double step = std::max(0.0, in.time_s - last_s_) / config_.blend_s;
  last_s_ = in.time_s;
  if (in.fingertips_tracked) tracked_s_ = in.time_s;

  switch (phase_) {
    case InspectionPhase::idle:
      return look_for_choice(in);

    case InspectionPhase::selected:
      if (in.fingertips_tracked && in.time_s - since_s_ >= config_.notice_s) {
        phase_ = InspectionPhase::attached;
        return InspectionEvent::attached;
      }
      if (in.distance_px[static_cast<std::size_t>(object_)] <= config_.away_px) near_s_ = in.time_s;
      if (in.time_s - near_s_ > config_.grace_s) {
        phase_ = InspectionPhase::idle;
        object_ = -1;
      }
      return std::nullopt;

    case InspectionPhase::attached:
      if (in.time_s - tracked_s_ > config_.grace_s) {
        phase_ = InspectionPhase::returning;
        way_ = std::max(0.0, way_ - step);
        return InspectionEvent::released;
      }
      way_ = std::min(1.0, way_ + step);
      return std::nullopt;

    case InspectionPhase::returning:
      way_ = std::max(0.0, way_ - step);
      if (way_ == 0) {
        phase_ = InspectionPhase::idle;
        object_ = -1;
        candidate_ = -1;
        must_leave_ = true;
      }
      return std::nullopt;
  }
  return std::nullopt;
}

Eigen::Isometry3d blend(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double weight) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = a.translation() + weight * (b.translation() - a.translation());
  T.linear() = Eigen::Quaterniond(a.linear())
                   .slerp(weight, Eigen::Quaterniond(b.linear()))
                   .toRotationMatrix();
  return T;
}

}  // namespace handyar::render
