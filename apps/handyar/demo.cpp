// SPDX-License-Identifier: MIT
#include <iostream>
#include <memory>

#include "command.hpp"
#include "handyar/io/sample.hpp"
#include "object_on_hand.hpp"
#include "output_folder.hpp"
#include "tracking_run.hpp"

namespace handyar::cli {
namespace {

int demo(const std::string& folder_path) {
  const OutputFolder folder(folder_path, {"poses.csv", "annotated.mp4"});
  TrackingRun run;
  run.input = "sample";
  run.camera_file = io::data_file("sample/camera.yml");
  run.hand_file = io::data_file("sample/hand.json");
  run.poses_out = folder.file("poses.csv");
  run.video_out = folder.file("annotated.mp4");
  ObjectOnHand teapot("teapot", 0.09);
  run.overlays[0] = [&](cv::Mat& bgr, std::int64_t, const AnyTracker& tracker, const Camera& camera,
                        const TrackResult& result) { teapot.draw(bgr, tracker, camera, result); };

  const Summary summary = track(run);
  std::cout << "the shipped clip: " << describe(summary) << "\n  annotated video  " << run.video_out
            << "\n  poses            " << run.poses_out << '\n';
  return exit_code(summary);
}

}  // namespace

Command add_demo(CLI::App& app) {
  CLI::App* options = app.add_subcommand("demo", "Track the hand in the shipped clip, end to end");
  const auto folder = std::make_shared<std::string>("handyar-demo");
  options->add_option("--out", *folder, "Folder for the annotated video and the poses")
      ->type_name("DIR")
      ->capture_default_str();
  options->footer("Example:\n  handyar demo --out /tmp/handyar-demo");
  return {options, [folder] { return demo(*folder); }};
}

}  // namespace handyar::cli
