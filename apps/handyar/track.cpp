// SPDX-License-Identifier: MIT
#include <cstdio>
#include <map>
#include <memory>
#include <ostream>
#include <vector>

#include "command.hpp"
#include "handyar/attachment.hpp"
#include "object_on_hand.hpp"
#include "remembered.hpp"
#include "tracking_run.hpp"

namespace handyar::cli {
namespace {

constexpr const char* kTrackExamples =
    "INPUT is a video file, a picture, a numbered series of pictures (frames/%04d.png), a camera\n"
    "(0, /dev/video0, or its name) or sample, the shipped clip.\n\n"
    "Examples:\n"
    "  handyar track 0 --show\n"
    "  handyar track hand.mp4 --camera camera.yml --hand hand.json --poses poses.csv\n"
    "  handyar track sample --video annotated.mp4 --model bunny\n\n"
    "Ctrl-C finishes the files; the exit code is then 130 for a file, 0 for a live camera.";

const std::map<std::string, Method> kMethods = {{"figure", Method::figure},
                                                {"paper", Method::paper}};
const std::map<std::string, paper::FingertipMethod> kFingertipMethods = {
    {"curvature", paper::FingertipMethod::curvature}, {"ellipse", paper::FingertipMethod::ellipse}};

// The options as they are typed, where that is not how the tracker has them.
struct Choices {
  std::string method = "figure", processing = "full", fingertips = "ellipse";
  bool no_filter = false, no_timings = false, no_annotation = false;
  std::string model, debug_frames, camera_size;
  std::string attach = "face";
  std::optional<double> model_mm;
};

std::vector<std::string> attachment_names() {
  std::vector<std::string> names;
  for (int i = 0; i < kAttachmentCount; ++i) names.emplace_back(name(static_cast<Attachment>(i)));
  return names;
}

FrameSet debug_frames_of(const Choices& choices, const TrackingRun& run) {
  if (choices.debug_frames.empty()) return {};
  if (run.debug_folder.empty()) throw WrongUsage("--debug-frames needs --debug");
  const auto frames = parse_frames(choices.debug_frames);
  if (!frames) throw WrongUsage("--debug-frames " + choices.debug_frames + " is not like 10,50-60");
  return *frames;
}

void ask_camera(const Choices& choices, TrackingRun& run) {
  if (choices.camera_size.empty()) return;
  io::CameraSettings& settings = run.camera_settings;
  int read = 0;
  const char* const text = choices.camera_size.c_str();
  if (std::sscanf(text, "%5dx%5d%n", &settings.width_px, &settings.height_px, &read) != 2 ||
      text[read] != '\0' || settings.width_px < 1 || settings.height_px < 1)
    throw WrongUsage("--camera-size " + choices.camera_size + " is not like 1280x720");
}

// With a window there may be one later even if there is none at first; where nothing takes pictures
// it is not drawn.
void stand_on_hand(const Choices& choices, TrackingRun& run) {
  require_distinct_files({choices.model},
                         {run.poses_out, run.video_out, run.events_out, run.record_out});
  if (choices.model.empty() && !run.show) {
    if (choices.model_mm || choices.attach != "face")
      throw WrongUsage("--model-mm and --attach need --model");
    return;
  }
  const Attachment where = *find_attachment(choices.attach);
  const double size_mm = choices.model_mm.value_or(on_finger(where) ? 25 : 90);
  std::vector<std::shared_ptr<ObjectOnHand>> objects;
  for (int i = 0; i < run.hands; ++i) {
    objects.push_back(std::make_shared<ObjectOnHand>(choices.model, size_mm / 1000, where));
    if (!run.show && run.video_out.empty()) continue;
    run.overlays[i] = [object = objects.back()](cv::Mat& bgr, std::int64_t,
                                                const AnyTracker& tracker, const Camera& camera,
                                                const TrackResult& result) {
      object->draw(bgr, tracker, camera, result);
    };
  }
  run.next_object = [objects] {
    for (const auto& object : objects) object->next();
  };
}

}  // namespace

Command add_track(CLI::App& app) {
  CLI::App* options = app.add_subcommand("track", "Track a hand in a video, pictures or a camera");
  const auto run = std::make_shared<TrackingRun>();
  const auto choices = std::make_shared<Choices>();
  options->add_option("INPUT", run->input, "What to track the hand in; else the remembered camera")
      ->type_name(" ");
  add_tracker_files(options, *run);
  options
      ->add_option("--camera-size", choices->camera_size, "Ask a camera for pictures like 1280x720")
      ->type_name("SIZE");
  options->add_option("--camera-fps", run->camera_settings.fps, "Ask a camera for so many a second")
      ->check(between(1, 1000));
  options->add_flag("--camera-lock", run->camera_settings.lock,
                    "Keep exposure, white balance and focus after the first second");
  options->add_option("--poses", run->poses_out, "Write one row per frame (CSV)")
      ->type_name("FILE");
  add_video(options, *run, "Write the annotated video");
  options
      ->add_option("--model", choices->model,
                   "Stand an object on the hand: teapot, bunny, or a file (OBJ, PLY, glTF)")
      ->type_name("MODEL");
  options
      ->add_option("--model-mm", choices->model_mm,
                   "The object's longest side; else 90, and 25 on a finger")
      ->check(between(1.0, 10000.0));
  options
      ->add_option("--attach", choices->attach,
                   "Where on the hand it stands: face (the visible one), palm, back, wrist,\n"
                   "thumb_base to little_base, thumb_tip to little_tip")
      ->type_name("PLACE")
      ->check(CLI::IsMember(attachment_names()))
      ->capture_default_str();
  options
      ->add_option("--events", run->events_out,
                   "Write when the hand is found and lost, grabs, releases and clicks (JSON lines)")
      ->type_name("FILE");
  options
      ->add_option("--record", run->record_out,
                   "Record the input without loss, with its times to the millisecond, to replay it "
                   "(.mkv)")
      ->type_name("FILE")
      ->check(ends_in({".mkv"}));
  options->add_flag("--show", run->show, "Show it in a window; ? there tells the keys, q ends");
  options->add_flag("--mirror", run->mirrored,
                    "Mirror what is shown, as one sees oneself; the poses stay as they are");
  options
      ->add_option("--debug", run->debug_folder,
                   "Write the stages from frame to pose, a picture (PNG) each")
      ->type_name("DIR");
  options->add_option("--debug-frames", choices->debug_frames, "Of these frames only: 10,50-60")
      ->type_name("FRAMES");
  options
      ->add_option("--method", choices->method,
                   "figure lays a 3-D hand on the picture; paper is the method of 2007 as written")
      ->check(CLI::IsMember(kMethods))
      ->capture_default_str();
  options
      ->add_option("--processing", choices->processing,
                   "With --method paper: at full or half the input's size")
      ->check(CLI::IsMember({"full", "half"}))
      ->capture_default_str();
  options
      ->add_option("--fingertips", choices->fingertips,
                   "With --method paper: how fingertips are measured")
      ->check(CLI::IsMember(kFingertipMethods))
      ->capture_default_str();
  options->add_option("--hands", run->hands, "How many hands at once, 1 or 2; not --method paper")
      ->check(between(1, 2))
      ->capture_default_str();
  options->add_flag("--no-annotation", choices->no_annotation,
                    "Leave contour, fingertips and axes off the pictures");
  options->add_flag("--no-filter", choices->no_filter, "Give the raw pose as the filtered one");
  options->add_flag("--no-timings", choices->no_timings,
                    "Leave the milliseconds out: the same input then gives the same file");
  options->footer(kTrackExamples);
  return {options, [run, choices] {
            run->method = kMethods.at(choices->method);
            run->paper_config.half_resolution = choices->processing == "half";
            run->paper_config.fingertips = kFingertipMethods.at(choices->fingertips);
            run->config.smoothing = choices->no_filter ? 0 : 1;
            run->paper_config.filter.enabled = !choices->no_filter;
            run->timings = !choices->no_timings;
            run->annotated = !choices->no_annotation;
            run->input = input_of(run->input);
            if (run->hands > 1 && run->method == Method::paper)
              throw WrongUsage("--method paper follows one hand, not --hands 2");
            if (run->method != Method::paper &&
                (choices->processing != "full" || choices->fingertips != "ellipse"))
              throw WrongUsage("--processing and --fingertips are for --method paper");
            ask_camera(*choices, *run);
            stand_on_hand(*choices, *run);
            run->debug_frames = debug_frames_of(*choices, *run);
            const Summary summary = track(*run);
            beside({run->poses_out, run->events_out}) << describe(summary) << '\n';
            return exit_code(summary);
          }};
}

}  // namespace handyar::cli
