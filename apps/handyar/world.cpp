// SPDX-License-Identifier: MIT
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <ostream>

#include "command.hpp"
#include "event_log.hpp"
#include "handyar/io/csv_row.hpp"
#include "handyar/io/error.hpp"
#include "handyar/opencv/annotate.hpp"
#include "handyar/world/world_tracker.hpp"
#include "remembered.hpp"
#include "tracking_run.hpp"
#include "world_stage.hpp"

namespace handyar::cli {
namespace {

constexpr const char* kWorldExamples =
    "Lay your open hand on the table for half a second: the world is set up there, and an object\n"
    "stands where the hand was. Hold the hand at it for half a second and it comes along; lay the\n"
    "hand down or take it away, and it stays. In the window, o adds another object.\n\n"
    "Examples:\n"
    "  handyar world 0 --show\n"
    "  handyar world desk.mp4 --map desk.map --video out.mp4\n"
    "  handyar world 0 --scene desk.json --show      the same table and objects, another day";

struct Choices {
  std::string map, scene, poses, events, model = "teapot";
  double model_mm = 90;
};

// One row for each frame (docs/formats.md).
class WorldCsv {
 public:
  explicit WorldCsv(const std::string& path) : file_(path), stream_(file_.stream()) {
    put("frame,time_s,state,qw,qx,qy,qz,tx_m,ty_m,tz_m,points,inliers,rms_px,sigma_rotation_rad,"
        "sigma_translation_m,hindrance");
  }
  void write(std::int64_t frame, double time_s, const world::WorldResult& world) {
    io::CsvRow row;
    row.text(std::to_string(frame));
    row.number(time_s, io::kTimeDigits);
    row.text(world::name(world.state));
    if (world.T_camera_world) {
      row.pose(*world.T_camera_world);
      row.text(std::to_string(world.points));
      row.text(std::to_string(world.inliers));
      row.number(world.rms_px, io::kPixelDigits);
      row.number(world.sigma_rotation_rad, io::kSigmaDigits);
      row.number(world.sigma_translation_m, io::kSigmaDigits);
    } else {
      row.empty(12);
    }
    if (world.hindrance)
      row.text(world::name(*world.hindrance));
    else
      row.empty(1);
    put(row.take());
  }
  void finish() {
    stream_.close();
    check();
    file_.commit();
  }

 private:
  void put(const std::string& line) {
    stream_ << line << '\n';
    check();
  }
  void check() const {
    if (!stream_) throw io::Error(file_.target(), "cannot be written");
  }

  io::PendingFile file_;
  std::ofstream stream_;
};

// What the person is to do so that the hand sets the frame.
std::string advice(world::Hindrance hindrance) {
  switch (hindrance) {
    case world::Hindrance::no_hand:
      return "lay the open hand down";
    case world::Hindrance::unsure:
      return "the hand is not seen well: spread the fingers";
    case world::Hindrance::tilted:
      return "the hand is seen from the side: look down on it";
    case world::Hindrance::bare:
      return "too little to see around the hand";
    case world::Hindrance::moving:
      return "the hand moves: keep still";
    case world::Hindrance::off_ground:
      break;
  }
  return "the hand is in the air: lay it down";
}

// What the person is to do, or to wait for; nothing once the world is there.
std::string advice(const world::WorldResult& world) {
  switch (world.state) {
    case world::WorldState::none:
    case world::WorldState::setting:
      return world.hindrance ? advice(*world.hindrance) : "keep still";
    case world::WorldState::tracked:
      return "";
    case world::WorldState::lost:
      break;
  }
  return "looking for the world";
}

bool there(const std::string& file) { return !file.empty() && std::filesystem::exists(file); }

// Everything of a run that the tracker of the hand does not do.
class WorldRun {
 public:
  WorldRun(const Choices& choices, const TrackingRun& run)
      : choices_(choices), scene_(scene_of(choices)), map_file_(map_file_of(choices, scene_)) {
    std::vector<std::string> inputs{run.input, run.camera_file, run.hand_file, choices.model};
    for (const render::SceneObject& object : scene_.objects) inputs.push_back(object.model);
    require_distinct_files(
        inputs, {run.video_out, choices.poses, choices.events, map_file_, choices.scene});
    if (there(map_file_)) opened_ = world::read_map(map_file_);
    if (!scene_.objects.empty() && !opened_)
      throw io::Error(choices.scene, "its map " + map_file_ + " is not there");
    for (const std::string& file : {map_file_, choices.scene})
      if (!file.empty()) io::require_writable(file);
    if (!choices.poses.empty()) poses_.emplace(choices.poses);
    if (!choices.events.empty()) events_.emplace(choices.events);
    if (run.show || !run.video_out.empty() || events_ || !choices.scene.empty())
      stage_.emplace(scene_.objects, choices.model, choices.model_mm / 1000);
    else
      render::find_model(choices.model);  // though nothing shows it, a fault in it is told
  }

  void observe(const cv::Mat& bgr, std::int64_t frame, const AnyTracker& hands,
               const Camera& camera, const TrackResult& result, bool live) {
    if (!tracker_) begin(camera, live);
    world_ = tracker_->process(bgr, result.time_s, world::HandInWorld::of(hands, result));
    ++frames_;
    tracked_ += world_.state == world::WorldState::tracked;
    lay_ |= world_.state == world::WorldState::setting;
    if (world_.hindrance && world_.hindrance != world::Hindrance::no_hand)
      ++hindered_[*world_.hindrance];
    if (poses_) poses_->write(frame, result.time_s, world_);
    if (events_) tell_changes(frame, result.time_s);
    if (stage_)
      stage_->update(world_, tracker_->map().get(), hands, result, frame,
                     events_ ? &*events_ : nullptr);
  }

  void draw(cv::Mat& bgr, const Camera& camera, const AnyTracker& hands) {
    stage_->draw(bgr, camera, hands);
    if (const std::string line = advice(world_); !line.empty()) draw_lines(bgr, {line});
  }

  void add_object() { stage_->add_next(); }

  void finish() {
    if (poses_ && frames_ > 0) poses_->finish();
    if (events_ && frames_ > 0) events_->finish();
    const auto map = tracker_ ? tracker_->map() : nullptr;
    if (!map) return;
    if (!map_file_.empty()) world::write_map(map_file_, *map);
    if (choices_.scene.empty() || !stage_) return;
    scene_.map = map_file_;
    scene_.objects = stage_->objects();
    render::write_scene(choices_.scene, scene_);
  }

  std::string describe() const {
    if (!tracker_ || !tracker_->map()) return "no world: " + why_none();
    const auto map = tracker_->map();
    return "world in " + std::to_string(tracked_) + " of " + std::to_string(frames_) + " frames, " +
           std::to_string(map->points.size()) + " points";
  }

 private:
  static render::Scene scene_of(const Choices& choices) {
    if (!there(choices.scene)) return {};
    render::Scene scene = render::read_scene(choices.scene);
    if (scene.map.empty()) throw io::Error(choices.scene, "is a scene of markers, not of a map");
    return scene;
  }

  static std::string map_file_of(const Choices& choices, const render::Scene& scene) {
    if (!choices.map.empty() || choices.scene.empty()) return choices.map;
    if (!scene.map.empty()) return scene.map;
    return std::filesystem::path(choices.scene).replace_extension(".map").string();
  }

  void begin(const Camera& camera, bool live) {
    const auto mapping = live ? world::Mapping::background : world::Mapping::at_once;
    if (opened_)
      tracker_.emplace(camera, std::move(*opened_), mapping);
    else
      tracker_.emplace(camera, mapping);
  }

  std::string why_none() const {
    if (hindered_.empty())
      return lay_ ? "the hand lay still for too short a time" : "no open hand was seen";
    const auto& [hindrance, frames] =
        *std::max_element(hindered_.begin(), hindered_.end(),
                          [](const auto& a, const auto& b) { return a.second < b.second; });
    return advice(hindrance) + " (in " + std::to_string(frames) + " of " + std::to_string(frames_) +
           " frames)";
  }

  void tell_changes(std::int64_t frame, double time_s) {
    const bool tracked = world_.state == world::WorldState::tracked;
    if (tracked == told_) return;
    told_ = tracked;
    events_->write(tracked ? "world_found" : "world_lost", frame, time_s,
                   nlohmann::ordered_json::object());
  }

  const Choices& choices_;
  render::Scene scene_;
  std::string map_file_;
  std::optional<world::WorldMap> opened_;
  std::optional<WorldCsv> poses_;
  std::optional<EventLog> events_;
  std::optional<WorldStage> stage_;
  std::optional<world::WorldTracker> tracker_;
  world::WorldResult world_;
  std::int64_t frames_ = 0, tracked_ = 0;
  std::map<world::Hindrance, std::int64_t> hindered_;  // a hand that is there: frames
  bool told_ = false, lay_ = false;
};

int world_of(TrackingRun run, const Choices& choices) {
  run.input = input_of(run.input);
  WorldRun world(choices, run);
  run.annotated = false;
  run.observer = [&](const cv::Mat& bgr, std::int64_t frame, const AnyTracker& tracker,
                     const Camera& camera, const TrackResult& result,
                     bool live) { world.observe(bgr, frame, tracker, camera, result, live); };
  if (run.show || !run.video_out.empty())
    run.overlays[0] = [&](cv::Mat& bgr, std::int64_t, const AnyTracker& tracker,
                          const Camera& camera,
                          const TrackResult&) { world.draw(bgr, camera, tracker); };
  run.next_object = [&] { world.add_object(); };
  Summary summary;
  try {
    summary = track(run);
  } catch (const io::Error&) {
    world.finish();
    throw;
  }
  world.finish();
  beside({choices.poses, choices.events})
      << world.describe() << "\nhand: " << describe(summary) << '\n';
  return exit_code(summary);
}

}  // namespace

Command add_world(CLI::App& app) {
  CLI::App* options =
      app.add_subcommand("world", "Set up a table with the hand and put objects on it");
  const auto run = std::make_shared<TrackingRun>();
  const auto choices = std::make_shared<Choices>();
  options->add_option("INPUT", run->input, "What to see the hand in; else the remembered camera")
      ->type_name(" ");
  add_tracker_files(options, *run);
  options
      ->add_option("--map", choices->map,
                   "The surroundings: opened where the file is there, saved at the end")
      ->type_name("FILE");
  options
      ->add_option("--scene", choices->scene,
                   "The objects and where they stand (JSON), likewise; without --map the map\n"
                   "that it names, or one beside it")
      ->type_name("FILE");
  options
      ->add_option("--model", choices->model,
                   "What stands where the hand was: teapot, bunny, or a file (OBJ, PLY, glTF)")
      ->type_name("MODEL")
      ->capture_default_str();
  options->add_option("--model-mm", choices->model_mm, "The object's longest side")
      ->check(between(1.0, 10000.0))
      ->capture_default_str();
  options->add_option("--poses", choices->poses, "Write the camera's pose in the world (CSV)")
      ->type_name("FILE");
  add_video(options, *run, "Write the video");
  options->add_option("--events", choices->events, "Write what happens, a line of JSON each")
      ->type_name("FILE");
  options->add_flag("--show", run->show, "Show it in a window; ? there tells the keys, q ends");
  options->footer(kWorldExamples);
  return {options, [run, choices] { return world_of(*run, *choices); }};
}

}  // namespace handyar::cli
