// SPDX-License-Identifier: MIT
#include "handyar/render/inspection_view.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "hand_distance.hpp"
#include "handyar/attachment.hpp"
#include "handyar/opencv/lens.hpp"

namespace handyar::render {
namespace {

constexpr double kFade_s = 0.3;
constexpr double kCatchUp_s = 0.15;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// On its way an object rises over the hand plane early and comes down on the palm, or leaves it,
/// from above: straight from behind the hand it would come through it.
Eigen::Isometry3d on_the_way(const Eigen::Isometry3d& T_camera_place,
                             const Eigen::Isometry3d& T_camera_stand, double weight) {
  constexpr double kLift_m = 0.05;
  constexpr double kRisen = 0.4;  // weight at which it is over the plane
  Eigen::Isometry3d T = blend(T_camera_place, T_camera_stand, weight);
  const Eigen::Vector3d up = T_camera_stand.linear().col(2);
  const double height_m = up.dot(T_camera_place.translation() - T_camera_stand.translation());
  const double ahead = std::min(1.0, weight / kRisen);
  const double risen = ahead * ahead * (3 - 2 * ahead);
  T.translation() += (height_m * (weight - risen) + 4 * weight * (1 - weight) * kLift_m) * up;
  return T;
}

double towards(double value, double target, double step) {
  return value + std::clamp(target - value, -step, step);
}

}  // namespace

InspectionView::InspectionView(const Scene& scene, const InspectionConfig& config,
                               std::shared_ptr<Context> context)
    : scene_(scene), world_(scene.markers), inspection_(config), renderer_(std::move(context)) {
  for (const SceneObject& object : scene.objects) {
    const Model model = find_model(object.model);
    Instance instance;
    instance.model = renderer_.add(model);
    instance.size_m = object.size_m;
    instance.colour = object.colour;
    instances_.push_back(instance);
    placed_.push_back({model.bounds(), std::nullopt, false, 0});
  }
  distances_px_.assign(scene.objects.size(), kInfinity);
}

std::optional<InspectionEvent> InspectionView::update(const cv::Mat& frame_bgr,
                                                      const Camera& camera, double time_s,
                                                      const HandInView& hand) {
  const double step_s = std::max(0.0, time_s - last_s_);
  last_s_ = time_s;
  world_.observe(frame_bgr, camera, time_s);
  place(step_s);
  follow_hand(hand, step_s);
  for (std::size_t i = 0; i < placed_.size(); ++i)
    distances_px_[i] = distance_to_px(i, camera, hand);
  const std::optional<InspectionEvent> event =
      inspection_.update({time_s, distances_px_, hand.T_camera_hand.has_value()});
  if (event) last_object_ = inspection_.object();
  glow_ = towards(glow_, inspection_.phase() == InspectionPhase::selected ? 1 : 0, step_s / 0.15);
  arrange(time_s);
  return event;
}

bool InspectionView::any_seen() const {
  return std::ranges::any_of(placed_,
                             [](const Placed& p) { return p.T_camera_object.has_value(); });
}

void InspectionView::draw(cv::Mat& frame_bgr, const Camera& camera, const HandInView& hand) {
  HandOccluder occluder;
  occluder.mask = hand.mask;
  // An object that is on the hand stays in front of the palm when the fingertips are lost.
  if (hand.T_camera_hand || inspection_.weight() > 0) occluder.T_camera_hand = T_camera_hand_;
  renderer_.draw(frame_bgr, camera, instances_, occluder);
}

void InspectionView::place(double step_s) {
  for (std::size_t i = 0; i < placed_.size(); ++i) {
    Placed& p = placed_[i];
    const SceneObject& object = scene_.objects[i];
    const auto T_camera_marker = world_.T_camera_marker(object.marker);
    p.seen = T_camera_marker.has_value();
    if (T_camera_marker) p.T_camera_object = *T_camera_marker * object.T_marker_object;
    p.shown = towards(p.shown, p.seen ? 1 : 0, step_s / kFade_s);
  }
}

void InspectionView::follow_hand(const HandInView& hand, double step_s) {
  if (!hand.T_camera_hand) {
    following_ = 0;
    return;
  }
  T_camera_hand_ = *hand.T_camera_hand;
  following_ = inspection_.weight() > 0 ? std::min(1.0, following_ + step_s / kCatchUp_s) : 1;
  const Attachment where = scene_.objects[static_cast<std::size_t>(last_object_)].attachment;
  T_camera_stand_ =
      blend(T_camera_stand_, T_camera_hand_ * T_hand_attachment(where, hand.model, hand.result),
            following_);
}

double InspectionView::distance_to_px(std::size_t i, const Camera& camera,
                                      const HandInView& hand) const {
  const Placed& p = placed_[i];
  if (!p.seen || !hand.fingertips_seen) return kInfinity;
  const double size_m = scene_.objects[i].size_m;
  const Eigen::Vector3d centre =
      *p.T_camera_object * Eigen::Vector3d(0, 0, 0.5 * size_m * p.box.sizes().z());
  const auto centre_px = shown_at(camera, centre);
  if (!centre_px) return kInfinity;
  const double radius_px = camera.fx_px * 0.5 * size_m / centre.z();
  const double distance = std::max(0.0, distance_px(hand.mask, *centre_px) - radius_px);
  return distance * 640.0 / camera.width_px;
}

void InspectionView::arrange(double time_s) {
  for (std::size_t i = 0; i < placed_.size(); ++i) {
    const Placed& p = placed_[i];
    Instance& instance = instances_[i];
    const double shown = p.T_camera_object ? p.shown : 0;
    instance.time_s = time_s;
    instance.ground = Ground::world;
    instance.opacity = static_cast<float>(shown * shown * (3 - 2 * shown));
    instance.shadow = 1;
    instance.glow = 0;
    if (p.T_camera_object) instance.T_camera_object = *p.T_camera_object;
    if (static_cast<int>(i) != last_object_) continue;

    instance.glow = static_cast<float>(glow_ * (0.85 + 0.15 * std::sin(2 * M_PI * 1.5 * time_s)));
    if (inspection_.object() != last_object_ || inspection_.weight() == 0) continue;
    // In the air it throws no shadow: the world's fades as it leaves, the hand's as it arrives.
    const double weight = inspection_.weight();
    instance.ground = weight > 0.5 ? Ground::hand : Ground::world;
    instance.shadow =
        static_cast<float>(std::max(0.0, weight > 0.5 ? 4 * weight - 3 : 1 - 4 * weight));
    instance.T_camera_object = p.T_camera_object
                                   ? on_the_way(*p.T_camera_object, T_camera_stand_, weight)
                                   : T_camera_stand_;
    instance.opacity = std::max(instance.opacity, static_cast<float>(weight));
  }
}

}  // namespace handyar::render
