// SPDX-License-Identifier: MIT
#include <iostream>
#include <map>
#include <memory>

#include "command.hpp"
#include "tracking_run.hpp"

namespace handyar::cli {
namespace {

constexpr const char* kExamples =
    "INPUT is a video file, a picture, a numbered series of pictures (frames/%04d.png), a camera\n"
    "(0, /dev/video0, or its name) or sample, the shipped clip.\n\n"
    "Examples:\n"
    "  handyar track 0 --show\n"
    "  handyar track hand.mp4 --camera camera.yml --hand hand.json --poses poses.csv\n"
    "  handyar track sample --video annotated.mp4\n\n"
    "Ctrl-C finishes the files; the exit code is then 130 for a file, 0 for a live camera.";

}  // namespace

Command add_track(CLI::App& app) {
  CLI::App* options = app.add_subcommand("track", "Track a hand in a video, pictures or a camera");
  const auto run = std::make_shared<TrackingRun>();
  options->add_option("INPUT", run->input, "What to track the hand in")->required();
  options->add_option("--camera", run->camera_file, "Camera file (YAML); else 60 degrees assumed");
  options->add_option("--hand", run->hand_file, "Hand file (JSON); else the average adult hand");
  options->add_option("--poses", run->poses_out, "Write one row per frame (CSV)");
  options->add_option("--video", run->video_out, "Write the annotated video (.mp4, .mkv, .avi)");
  options->add_flag("--show", run->show, "Show it in a window; q or Esc ends");
  options
      ->add_option("--processing", run->config.half_resolution,
                   "Work at full or half the input's size")
      ->transform(
          CLI::CheckedTransformer(std::map<std::string, bool>{{"full", false}, {"half", true}}))
      ->default_str("full");
  options->add_option("--fingertips", run->config.fingertips.method, "How fingertips are measured")
      ->transform(CLI::CheckedTransformer(std::map<std::string, FingertipMethod>{
          {"curvature", FingertipMethod::curvature}, {"ellipse", FingertipMethod::ellipse}}))
      ->default_str("ellipse");
  options->add_flag("!--no-filter", run->config.filter.enabled,
                    "Give the raw pose as the filtered");
  options->add_flag("!--no-timings", run->timings,
                    "Leave the milliseconds out: the same input then gives the same file");
  options->footer(kExamples);
  return {options, [run] {
            const Summary summary = track(*run);
            std::cout << describe(summary) << '\n';
            return exit_code(summary);
          }};
}

}  // namespace handyar::cli
