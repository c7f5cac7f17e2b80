// SPDX-License-Identifier: MIT
#include "handyar/attachment.hpp"

#include <array>

#include "handyar/stages/evidence.hpp"
#include "handyar/stages/hand_figure.hpp"

namespace handyar {
namespace {

constexpr std::array<std::string_view, kAttachmentCount> kNames = {
    "face",      "palm",        "back",      "wrist",     "thumb_base", "index_base", "middle_base",
    "ring_base", "little_base", "thumb_tip", "index_tip", "middle_tip", "ring_tip",   "little_tip"};

constexpr int number(Attachment where) { return static_cast<int>(where); }

/// The thumb leaves the palm at its second joint, the other fingers at their first.
int base_sphere(int finger) { return sphere_of(finger, finger == 0 ? 1 : 0); }

/// Standing at a point, up out of the visible face (`side` 1) or of the other one (-1), looking
/// towards the wrist.
Eigen::Isometry3d standing(const Eigen::Vector3d& p_hand, double side) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = p_hand;
  T.linear().col(0) = -Eigen::Vector3d::UnitY();
  T.linear().col(1) = side * Eigen::Vector3d::UnitX();
  T.linear().col(2) = side * Eigen::Vector3d::UnitZ();
  return T;
}

/// On a fingertip, up along the finger's last segment.
Eigen::Isometry3d on_tip(const PosedFigure& posed, int finger) {
  const Eigen::Vector3d end_m = posed.centres_m.col(sphere_of(finger, 3));
  const Eigen::Vector3d along = (end_m - posed.centres_m.col(sphere_of(finger, 2))).normalized();
  // Across the finger also when its end points at the camera.
  const Eigen::Vector3d from_root = end_m - posed.centres_m.col(sphere_of(finger, 0));
  const Eigen::Vector3d across(from_root.y(), -from_root.x(), 0);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = posed.tips_m.col(finger);
  T.linear().col(2) = along;
  T.linear().col(1) = (across - along.dot(across) * along).normalized();
  T.linear().col(0) = T.linear().col(1).cross(along);
  return T;
}

}  // namespace

std::string_view name(Attachment where) noexcept { return kNames[number(where)]; }

std::optional<Attachment> find_attachment(std::string_view name) noexcept {
  for (int i = 0; i < kAttachmentCount; ++i)
    if (kNames[i] == name) return static_cast<Attachment>(i);
  return std::nullopt;
}

Eigen::Isometry3d T_hand_attachment(Attachment where, const HandModel& hand,
                                    const TrackResult& result) noexcept {
  const Face seen = result.face.value_or(Face::palm);
  const bool wants_other_side = (where == Attachment::palm && seen == Face::back) ||
                                (where == Attachment::back && seen == Face::palm);
  if (where <= Attachment::back && !wants_other_side) return standing(hand.palm_centre_m(), 1);

  const HandFigure figure = make_figure(hand, seen, result.layout.value_or(hand.layout));
  const auto over = [&](const Eigen::Vector3d& p_hand, double radius_m, double side) {
    return standing(p_hand + side * radius_m * Eigen::Vector3d::UnitZ(), side);
  };
  const Eigen::Vector3d wrist_m =
      0.5 * (figure.centres_m.col(kWristThumb) + figure.centres_m.col(kWristLittle));
  const double wrist_radius_m = 0.5 * (figure.radii_m[kWristThumb] + figure.radii_m[kWristLittle]);
  if (where == Attachment::wrist) return over(wrist_m, wrist_radius_m, 1);

  if (wants_other_side) {
    // In the middle the hand is as thick as in the mean between the middle finger's root and the
    // wrist.
    const int root = sphere_of(static_cast<int>(Finger::middle), 0);
    Eigen::Vector3d middle_m = hand.palm_centre_m();
    middle_m.z() = 0.5 * (figure.centres_m(2, root) + wrist_m.z());
    return over(middle_m, 0.5 * (figure.radii_m[root] + wrist_radius_m), -1);
  }

  const PosedFigure posed = pose_fingers(figure, posture_of(result));
  if (where >= Attachment::thumb_tip)
    return on_tip(posed, number(where) - number(Attachment::thumb_tip));
  const int base = base_sphere(number(where) - number(Attachment::thumb_base));
  return over(posed.centres_m.col(base), figure.radii_m[base], 1);
}

}  // namespace handyar
