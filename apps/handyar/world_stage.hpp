// SPDX-License-Identifier: MIT
#pragma once

#include <map>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "event_log.hpp"
#include "handyar/paper/any_tracker.hpp"
#include "handyar/render/renderer.hpp"
#include "handyar/render/scene.hpp"
#include "handyar/world/placement.hpp"
#include "handyar/world/world_tracker.hpp"

namespace handyar::cli {

/// The objects of a world that the hand has set up: where they stand, and how they look in a
/// frame.
class WorldStage {
 public:
  /// `model`: what stands where the hand was, when `objects` is empty, and what is added next.
  /// Throws io::Error where a model cannot be read or drawn.
  WorldStage(std::vector<render::SceneObject> objects, const std::string& model, double size_m);

  /// Takes the next frame's results; tells the log, if there is one, what happened.
  void update(const world::WorldResult& world, const world::WorldMap* map,
              const AnyTracker& tracker, const TrackResult& result, std::int64_t frame,
              EventLog* log);
  void draw(cv::Mat& bgr, const Camera& camera, const AnyTracker& tracker);

  /// One object more, on the hand or where the hand set the frame.
  void add_next();

  /// As they stand now.
  std::vector<render::SceneObject> objects() const;

 private:
  struct Object {
    render::SceneObject what;
    render::Instance instance;
    world::Placement placement;
  };
  int number_of(const std::string& model);  // the renderer's
  void add(const render::SceneObject& what);
  void add(const std::string& model, const Eigen::Isometry3d& T_world_object);
  void move(std::size_t which, double time_s, const world::WorldMap& map,
            const std::optional<Eigen::Isometry3d>& T_world_stand, std::int64_t frame,
            EventLog* log);

  render::Renderer renderer_;
  std::map<std::string, int> numbers_;
  std::vector<std::string> offered_;  // models, in the order in which they are added
  double size_m_;
  std::vector<Object> objects_;
  std::optional<Eigen::Isometry3d> T_camera_world_, T_camera_hand_, T_world_stand_;
  double shown_ = 0, last_s_ = 0;  // fades in and out, 0 .. 1
  bool asked_ = false;             // for one object more, before there was a world
};

}  // namespace handyar::cli
