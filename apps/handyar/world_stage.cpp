// SPDX-License-Identifier: MIT
#include "world_stage.hpp"

#include <algorithm>

#include "handyar/attachment.hpp"

namespace handyar::cli {
namespace {

constexpr double kFade_s = 0.2;

}  // namespace

WorldStage::WorldStage(std::vector<render::SceneObject> objects, const std::string& model,
                       double size_m)
    : offered_{model}, size_m_(size_m), asked_(objects.empty()) {
  for (const char* const other : {"teapot", "bunny"})
    if (model != other) offered_.push_back(other);
  number_of(model);  // a file that cannot be read is known before the first frame
  for (const render::SceneObject& object : objects) add(object);
}

int WorldStage::number_of(const std::string& model) {
  const auto known = numbers_.find(model);
  if (known != numbers_.end()) return known->second;
  return numbers_[model] = renderer_.add(render::find_model(model));
}

void WorldStage::add(const render::SceneObject& what) {
  render::Instance instance;
  instance.model = number_of(what.model);
  instance.size_m = what.size_m;
  instance.colour = what.colour;
  objects_.push_back({what, instance, world::Placement(what.T_marker_object)});
}

void WorldStage::add(const std::string& model, const Eigen::Isometry3d& T_world_object) {
  render::SceneObject what;
  const auto has_name = [&](const Object& object) { return object.what.name == what.name; };
  std::size_t number = objects_.size();
  do {  // a scene of names that are used twice would not be read again
    what.name = "object " + std::to_string(++number);
  } while (std::ranges::any_of(objects_, has_name));
  what.model = model;
  what.size_m = size_m_;
  what.T_marker_object = T_world_object;
  add(what);
}

void WorldStage::add_next() { asked_ = true; }

void WorldStage::update(const world::WorldResult& world, const world::WorldMap* map,
                        const AnyTracker& tracker, const TrackResult& result, std::int64_t frame,
                        EventLog* log) {
  const double step = std::max(0.0, result.time_s - last_s_) / kFade_s;
  last_s_ = result.time_s;
  const bool known = world.T_camera_world.has_value();
  shown_ = std::clamp(shown_ + (known ? step : -step), 0.0, 1.0);
  T_camera_hand_ = world::HandInWorld::of(tracker, result).T_camera_hand;
  if (!known || map == nullptr) {
    T_camera_world_.reset();
    return;
  }
  T_camera_world_ = world.T_camera_world;
  T_world_stand_.reset();
  if (T_camera_hand_)
    T_world_stand_ = T_camera_world_->inverse() * *T_camera_hand_ *
                     T_hand_attachment(Attachment::face, tracker.hand(), result);
  if (asked_) {
    asked_ = false;
    add(offered_[objects_.size() % offered_.size()],
        T_world_stand_.value_or(Eigen::Isometry3d::Identity()));
  }
  // One at a time: while one is carried, the hand is not there for the others.
  const auto carried = std::find_if(objects_.begin(), objects_.end(),
                                    [](const Object& o) { return o.placement.carried(); });
  const std::ptrdiff_t busy = carried == objects_.end() ? -1 : carried - objects_.begin();
  for (std::ptrdiff_t i = 0; i < std::ssize(objects_); ++i)
    move(static_cast<std::size_t>(i), result.time_s, *map,
         busy < 0 || busy == i ? T_world_stand_ : std::nullopt, frame, log);
}

void WorldStage::move(std::size_t which, double time_s, const world::WorldMap& map,
                      const std::optional<Eigen::Isometry3d>& T_world_stand, std::int64_t frame,
                      EventLog* log) {
  Object& object = objects_[which];
  const auto event = object.placement.update(time_s, map.ground, T_world_stand);
  object.what.T_marker_object = object.placement.T_world_object();
  object.instance.time_s = time_s;
  object.instance.ground =
      object.placement.carried() ? render::Ground::hand : render::Ground::world;
  if (event && log != nullptr)
    log->write(world::name(*event), frame, time_s, {{"object", object.what.name}});
}

void WorldStage::draw(cv::Mat& bgr, const Camera& camera, const AnyTracker& tracker) {
  if (!T_camera_world_ || objects_.empty()) return;
  std::vector<render::Instance> instances;
  for (const Object& object : objects_) {
    instances.push_back(object.instance);
    instances.back().T_camera_object = *T_camera_world_ * object.placement.T_world_object();
    instances.back().opacity = static_cast<float>(shown_);
  }
  renderer_.draw(bgr, camera, instances, {tracker.mask(), T_camera_hand_, 0.008});
}

std::vector<render::SceneObject> WorldStage::objects() const {
  std::vector<render::SceneObject> result;
  for (const Object& object : objects_) result.push_back(object.what);
  return result;
}

}  // namespace handyar::cli
