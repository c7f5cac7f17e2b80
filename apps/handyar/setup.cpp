// SPDX-License-Identifier: MIT
#include <filesystem>
#include <iostream>
#include <memory>

#include "calibrate.hpp"
#include "command.hpp"
#include "handyar/io/cameras.hpp"
#include "handyar/io/frame_source.hpp"
#include "remembered.hpp"

namespace handyar::cli {
namespace {

constexpr const char* kNotes =
    "What is remembered is taken by the other commands where nothing is given: the camera as\n"
    "INPUT, its calibration when INPUT is a camera, the hand always (--hand average: not).\n\n"
    "Examples:\n"
    "  handyar setup 0 --show --hand-length-mm 187   hold up the open hand, turn it, press q\n"
    "  handyar setup --camera camera.yml --hand hand.json\n"
    "  handyar setup                                 says what is remembered";

struct Setup {
  std::string input, camera_file, hand_file;
  double hand_length_mm = 0, span_mm = 0;
  bool forget = false, show = false;

  bool measures_hand() const { return hand_length_mm > 0 || span_mm > 0; }
};

// The hand alone, turned before the camera.
int measure_hand(const Setup& setup) {
  CalibrateRun run;
  run.input = setup.input.empty() ? remembered().input : setup.input;
  if (run.input.empty()) throw WrongUsage("which camera is the hand to be held before?");
  run.camera_file = setup.camera_file;
  run.self = run.assume_camera = true;
  run.show = setup.show;
  run.span_mm = setup.span_mm;
  run.hand_length_mm = setup.hand_length_mm;
  std::filesystem::create_directories(config_folder());
  run.hand_out = config_folder() + "/hand.json";
  return calibrate(run);
}

void choose_camera(const std::string& input) {
  const io::SourceInfo info = io::open_input(input)->info();
  if (!info.live) throw WrongUsage(input + " is no camera");
  remember_input(info.name);
}

int print_remembered() {
  const Remembered r = remembered();
  const auto or_none = [](const std::string& what) { return what.empty() ? "none" : what; };
  std::cout << "camera       " << or_none(r.input) << "\ncalibration  " << or_none(r.camera_file)
            << "\nhand         " << or_none(r.hand_file) << '\n';
  return kDone;
}

int set_up(const Setup& setup) {
  if (setup.show && !setup.measures_hand())
    throw WrongUsage("--show needs --hand-length-mm or --span-mm");
  if (setup.forget) forget();
  if (!setup.camera_file.empty()) remember_camera(setup.camera_file);
  if (!setup.hand_file.empty()) remember_hand(setup.hand_file);
  if (setup.measures_hand())
    if (const int code = measure_hand(setup); code != kDone) return code;
  if (!setup.input.empty() && !(setup.measures_hand() && !io::open_input(setup.input)->info().live))
    choose_camera(setup.input);
  return print_remembered();
}

}  // namespace

Command add_setup(CLI::App& app) {
  CLI::App* options = app.add_subcommand("setup", "Remember camera and hand");
  const auto setup = std::make_shared<Setup>();
  options->add_option("INPUT", setup->input, "The camera; or a recording of the hand")
      ->type_name(" ");
  options->add_option("--camera", setup->camera_file, "Its calibration (YAML)")->type_name("FILE");
  options->add_option("--hand", setup->hand_file, "The hand (JSON)")->type_name("FILE");
  options
      ->add_option("--hand-length-mm", setup->hand_length_mm,
                   "Measure the hand: crease of the wrist to tip of the middle finger")
      ->excludes("--hand")
      ->check(between(80.0, 300.0));
  options
      ->add_option("--span-mm", setup->span_mm,
                   "Measure the hand: thumb tip to little fingertip, as spread")
      ->excludes("--hand", "--hand-length-mm")
      ->check(between(50.0, 350.0));
  options->add_flag("--show", setup->show, "Show what is seen while the hand is measured");
  options->add_flag("--forget", setup->forget, "Forget what was remembered before");
  options->footer(kNotes);
  return {options, [setup] { return set_up(*setup); }};
}

}  // namespace handyar::cli
