// SPDX-License-Identifier: MIT
#include <filesystem>
#include <iostream>
#include <memory>

#include "command.hpp"
#include "handyar/io/error.hpp"
#include "handyar/io/sample.hpp"
#include "object_on_hand.hpp"
#include "tracking_run.hpp"

namespace fs = std::filesystem;

namespace handyar::cli {
namespace {

int demo(const std::string& folder, const std::string& skin_file) {
  std::error_code fault;
  fs::create_directories(folder, fault);
  if (fault) throw io::Error(folder, "cannot be made: " + fault.message());

  TrackingRun run;
  run.input = "sample";
  run.camera_file = io::data_file("sample/camera.yml");
  run.hand_file = io::data_file("sample/hand.json");
  run.skin_file = skin_file;
  run.poses_out = (fs::path(folder) / "poses.csv").string();
  run.video_out = (fs::path(folder) / "annotated.mp4").string();
  run.overlay = object_on_hand("teapot", 0.09);

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
  const auto skin = std::make_shared<std::string>();
  options->add_option("--skin", *skin, kSkinHelp)->type_name("FILE");
  options->footer("Example:\n  handyar demo --out /tmp/handyar-demo");
  return {options, [folder, skin] { return demo(*folder, *skin); }};
}

}  // namespace handyar::cli
