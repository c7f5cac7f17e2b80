// SPDX-License-Identifier: MIT
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>

#include "calibrate.hpp"
#include "command.hpp"
#include "handyar/io/camera_file.hpp"
#include "handyar/io/frame_source.hpp"
#include "handyar/io/hand_file.hpp"
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
  const Remembered known = setup.forget ? Remembered{} : remembered();
  CalibrateRun run;
  run.input = setup.input.empty() ? known.input : setup.input;
  if (run.input.empty()) throw WrongUsage("which camera is the hand to be held before?");
  run.camera_file = setup.camera_file;
  run.self = run.assume_camera = true;
  run.live_camera_file = known.camera_file;
  run.show = setup.show;
  run.span_mm = setup.span_mm;
  run.hand_length_mm = setup.hand_length_mm;
  std::filesystem::create_directories(config_folder());
  run.hand_out = config_folder() + "/hand.json";
  return calibrate(run);
}

// What INPUT is remembered as; empty where there is none, or a recording of the hand.
std::string camera_in(const Setup& setup) {
  if (setup.input.empty()) return "";
  const io::SourceInfo info = io::open_input(setup.input)->info();
  if (!info.live && !setup.measures_hand()) throw WrongUsage(setup.input + " is no camera");
  return info.live ? info.name : "";
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
  // Whatever can fail comes first: what was remembered stays as it was until all is known.
  std::optional<Camera> camera;
  std::optional<HandModel> hand;
  if (!setup.camera_file.empty()) camera = io::read_camera(setup.camera_file);
  if (!setup.hand_file.empty()) hand = io::read_hand(setup.hand_file);
  const std::string input = camera_in(setup);
  if (setup.measures_hand())
    if (const int code = measure_hand(setup); code != kDone) return code;
  if (setup.forget) forget(!setup.measures_hand());
  if (!input.empty()) remember_input(input);
  if (camera) remember_camera(*camera);
  if (hand) remember_hand(*hand);
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
