// SPDX-License-Identifier: MIT
#include <memory>
#include <optional>
#include <ostream>

#include "command.hpp"
#include "event_log.hpp"
#include "handyar/io/error.hpp"
#include "handyar/render/inspection_view.hpp"
#include "remembered.hpp"
#include "tracking_run.hpp"

namespace handyar::cli {
namespace {

constexpr const char* kInspectExamples =
    "Hold your hand near an object until it glows, stretch your fingers, and it comes over; fold\n"
    "them and it goes back.\n\n"
    "Examples:\n"
    "  handyar inspect 0 --scene scene.json --camera camera.yml --hand hand.json --show\n"
    "  handyar inspect desk.mp4 --scene scene.json --video out.mp4 --events events.jsonl";

int inspect(TrackingRun run, const std::string& scene_file, const std::string& events_file) {
  run.input = input_of(run.input);
  require_distinct_files({run.input, run.camera_file, run.hand_file, scene_file},
                         {run.video_out, events_file});
  const render::Scene scene = render::read_scene(scene_file);
  if (scene.markers.empty()) throw io::Error(scene_file, "is a scene of a map, not of markers");
  for (const render::SceneObject& object : scene.objects)
    require_distinct_files({object.model}, {run.video_out, events_file});
  render::InspectionView view(scene);
  std::optional<EventLog> log;
  if (!events_file.empty()) log.emplace(events_file);

  run.annotated = false;
  bool begun = false;
  const bool pictures = run.show || !run.video_out.empty();
  run.overlays[0] = [&](cv::Mat& bgr, std::int64_t frame, const AnyTracker& tracker,
                        const Camera& camera, const TrackResult& result) {
    begun = true;
    const auto hand = render::HandInView::of(tracker, result);
    const auto event = view.update(bgr, camera, result.time_s, hand);
    if (pictures) view.draw(bgr, camera, hand);
    if (event && log)
      log->write(render::name(*event), frame, result.time_s, {{"object", view.object().name}});
  };
  Summary summary;
  try {
    summary = track(run);
  } catch (const io::Error&) {
    if (log && begun) log->finish();
    throw;
  }
  if (log) log->finish();
  beside({events_file}) << describe(summary)
                        << (view.any_seen() ? "\n" : "\nno marker of the scene was seen\n");
  return exit_code(summary);
}

}  // namespace

Command add_inspect(CLI::App& app) {
  CLI::App* options = app.add_subcommand(
      "inspect", "Take objects from their markers with the hand and look at them from all sides");
  const auto run = std::make_shared<TrackingRun>();
  const auto scene = std::make_shared<std::string>();
  const auto events = std::make_shared<std::string>();
  options->add_option("INPUT", run->input, "What to see the hand in; else the remembered camera")
      ->type_name(" ");
  options->add_option("--scene", *scene, "Scene file: objects and their markers (JSON)")
      ->required();
  add_tracker_files(options, *run);
  add_video(options, *run, "Write the video");
  options->add_option("--events", *events, "Write what happens, a line of JSON each")
      ->type_name("FILE");
  options->add_flag("--show", run->show, "Show it in a window; q or Esc ends");
  options->footer(kInspectExamples);
  return {options, [run, scene, events] { return inspect(*run, *scene, *events); }};
}

}  // namespace handyar::cli
