// SPDX-License-Identifier: MIT
#include "calibrate.hpp"

#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>

#include "command.hpp"
#include "handyar/calibration/picture.hpp"
#include "handyar/calibration/self_calibration.hpp"
#include "handyar/calibration/session.hpp"
#include "handyar/io/camera_file.hpp"
#include "handyar/io/error.hpp"
#include "handyar/io/frame_source.hpp"
#include "handyar/io/hand_file.hpp"
#include "handyar/io/pending_file.hpp"
#include "handyar/io/picture_file.hpp"
#include "handyar/opencv/annotate.hpp"
#include "handyar/render/window.hpp"
#include "remembered.hpp"

namespace handyar::cli {
namespace {

constexpr const char* kNotes =
    "The hand lies flat beside the board, back up, fingers spread, and stays still; the camera\n"
    "moves slowly around both. --board counts inner corners: 9x7 squares have 8x6.\n"
    "With --self there is no board: the stiff, open hand turns before a calibrated camera.\n\n"
    "Examples:\n"
    "  handyar board --out board.pdf\n"
    "  handyar calibrate 0 --show --board 8x6 --square-mm 25 --camera-out camera.yml --hand-out "
    "hand.json\n"
    "  handyar calibrate hand.mp4 --camera camera.yml --self --span-mm 190 --hand-out hand.json";

Board board_of(const CalibrateRun& run) {
  if (run.grid.empty() || run.square_mm <= 0)
    throw WrongUsage("--board and --square-mm are needed, or --self and --camera");
  const auto grid = parse_grid(run.grid);
  if (!grid) throw WrongUsage("--board " + run.grid + " is not like 8x6, from 3x3 to 50x50");
  return {grid->width, grid->height, run.square_mm / 1000};
}

void check_usage(const CalibrateRun& run) {
  if (!run.self) board_of(run);
  if (!run.wants_hand() && run.camera_out.empty())
    throw WrongUsage("nothing to write: give --camera-out, --hand-out or --picture");
  require_distinct_files({run.input, run.camera_file},
                         {run.camera_out, run.hand_out, run.picture_out});
}

// The window, where one is wanted, and the picture in it.
struct Shown {
  std::optional<render::Window> window;
  cv::Mat picture;

  Shown(const CalibrateRun& run, const io::SourceInfo& info) {
    if (run.show) window.emplace(info.width_px, info.height_px, "handyar calibrate");
  }
  // False when the person before it has ended the run.
  bool show() { return !window || picture.empty() || window->show(picture, 0.001); }
};

// Hands every frame to `take` with what the tracker sees in it, until the input ends, the person
// ends it or `take` gives false.
template <class Take>
void watch(io::FrameSource& source, const Camera& camera, Shown& shown, Take take) {
  HandTracker tracker(camera, average_adult_hand());
  io::Frame frame;
  catch_interrupts();
  source.ask_while_waiting([&] { return interrupt() == 0 && shown.show(); });
  while (interrupt() == 0 && source.read(frame)) {
    const TrackResult result = tracker.process(frame.view(), frame.time_s);
    if (result.status != FrameStatus::ok)
      throw io::Error(source.info().name, handyar::describe(result.status));
    const bool wants_more = take(frame, tracker, result);
    if (!shown.show() || !wants_more) break;
  }
}

void report(const CameraCalibration& c, std::size_t frames) {
  std::printf(
      "camera: focal length %.1f +- %.1f px, centre (%.1f, %.1f) +- %.1f px, distortion: %s; "
      "%.2f px rms over %zu of %zu frames\n",
      c.camera.fx_px, c.focal_sigma_px, c.camera.cx_px, c.camera.cy_px, c.centre_sigma_px,
      c.distortion.c_str(), c.rms_px, c.views_used.size(), frames);
}

/// `hand` is the one of the two that is written.
void report(const HandCalibration& c, const HandModel& hand, double thickness_mm) {
  const double sigma_m = std::sqrt(hand.tips_sigma_m.topRows<2>().array().square().mean());
  char sigma[32] = "";
  if (sigma_m > 0) std::snprintf(sigma, sizeof sigma, ", tips +- %.1f mm", 1000 * sigma_m);
  std::printf(
      "hand: %.1f mm from thumb tip to little fingertip, %s%s; %.2f px rms, the worst tenth left "
      "out, over %zu frames\n",
      1000 * hand.span_m(), std::string(name(hand.layout)).c_str(), sigma, hand.rms_px,
      c.views_used.size());
  std::printf(
      "triangulated fingertips lie %.1f mm above the board; at %.4g mm, the paper's way, "
      "they lie %.1f mm rms elsewhere in the plane\n",
      1000 * c.height_m, thickness_mm, 1000 * c.rms_difference_m);
}

void report(const SelfCalibration& c) {
  std::printf(
      "hand: %.1f mm from thumb tip to little fingertip at rest, %s, tips +- %.1f mm; learned over "
      "%d frames, seen from directions up to %.0f degrees apart\n",
      1000 * c.hand.span_m(), std::string(name(c.hand.layout)).c_str(),
      1000 * std::sqrt(c.hand.tips_sigma_m.topRows<2>().array().square().mean()), c.views,
      c.turned_rad * 180 / CV_PI);
  if (c.hand.average_scale)
    std::printf(
        "no --span-mm or --hand-length-mm: the shape is this hand's, the size the average "
        "adult's\n");
}

int calibrate_with_board(const CalibrateRun& run, io::FrameSource& source,
                         const Camera* known_camera) {
  const io::SourceInfo& info = source.info();
  const Board board = board_of(run);
  CalibrationSession session(board, {info.width_px, info.height_px}, run.wants_hand());
  Shown shown(run, info);
  {
    ProgressLine progress;
    watch(source,
          known_camera ? *known_camera : Camera::from_field_of_view(info.width_px, info.height_px),
          shown,
          [&](const io::Frame& frame, const HandTracker& tracker, const TrackResult& result) {
            const auto& view = session.add(frame.bgr, result, tracker.hand());
            const Coverage& coverage = session.coverage();
            progress.show(std::ssize(session.views()), info.frame_count,
                          " frames, " + std::to_string(coverage.views()) + " different views, " +
                              std::to_string(coverage.hand_views()) + " of them with the hand");
            if (shown.window) shown.picture = draw_guidance(frame.bgr, coverage, view);
            return !(info.live && coverage.done());
          });
  }
  if (!info.live) require_no_interrupt();

  Camera camera;
  if (known_camera) {
    camera = *known_camera;
  } else {
    const CameraCalibration c = session.camera();
    report(c, session.views().size());
    camera = c.camera;
  }
  std::optional<HandCalibration> hand;
  HandModel measured;
  if (run.wants_hand()) {
    hand = calibrate_hand(session.views(), camera, board, run.thickness_mm / 1000);
    measured = run.method == "plane" ? hand->by_plane : hand->by_triangulation;
    report(*hand, measured, run.thickness_mm);
  }
  // The picture first: where it cannot be written, no hand and camera are left of a failed run.
  if (!run.picture_out.empty())
    io::write_picture(run.picture_out, draw_hand({hand->by_triangulation, board, hand->T_board_hand,
                                                  hand->plane_tips.p_m}));
  if (!run.hand_out.empty()) io::write_hand(run.hand_out, measured);
  if (!run.camera_out.empty()) io::write_camera(run.camera_out, camera);
  return kDone;
}

int calibrate_itself(const CalibrateRun& run, io::FrameSource& source, const Camera& camera) {
  const io::SourceInfo& info = source.info();
  std::vector<CalibrationView> views;
  Shown shown(run, info);
  int with_hand = 0;
  {
    ProgressLine progress;
    watch(source, camera, shown,
          [&](const io::Frame& frame, const HandTracker& tracker, const TrackResult& result) {
            views.push_back(hand_view(result, tracker.hand()));
            with_hand += views.back().hand_seen();
            progress.show(std::ssize(views), info.frame_count,
                          " frames, " + std::to_string(with_hand) + " with five fingertips");
            if (!shown.window) return true;
            frame.bgr.copyTo(shown.picture);
            annotate(shown.picture, tracker.mask(), camera, result);
            return true;
          });
  }
  if (!info.live) require_no_interrupt();
  KnownLength known;
  if (run.span_mm > 0) known.span_m = run.span_mm / 1000;
  if (run.hand_length_mm > 0) known.hand_length_m = run.hand_length_mm / 1000;
  const SelfCalibration c = self_calibrate_hand(views, camera, known);
  report(c);
  if (!run.picture_out.empty()) io::write_picture(run.picture_out, draw_hand({c.hand, {}, {}, {}}));
  if (!run.hand_out.empty()) io::write_hand(run.hand_out, c.hand);
  return kDone;
}

}  // namespace

int calibrate(const CalibrateRun& run) {
  check_usage(run);
  const std::unique_ptr<io::FrameSource> source = io::open_input(run.input);
  const io::SourceInfo& info = source->info();
  for (const std::string& out : {run.camera_out, run.hand_out, run.picture_out})
    if (!out.empty()) io::require_writable(out);
  const std::string camera_file =
      run.camera_file.empty() && info.live ? run.live_camera_file : run.camera_file;
  std::optional<Camera> camera;
  if (!camera_file.empty()) {
    camera = io::camera_for_size(io::read_camera(camera_file), info.width_px, info.height_px,
                                 camera_file);
    if (camera->assumed)
      std::cerr << "handyar: " << camera_file << ": its field of view is assumed, not calibrated\n";
  } else if (run.assume_camera) {
    camera = Camera::from_field_of_view(info.width_px, info.height_px);
    std::cerr << "handyar: no --camera: a field of view of 60 degrees is assumed\n";
  }
  try {
    return run.self ? calibrate_itself(run, *source, *camera)
                    : calibrate_with_board(run, *source, camera ? &*camera : nullptr);
  } catch (const CalibrationError& e) {
    throw io::Error(info.name, e.what());
  }
}

Command add_calibrate(CLI::App& app) {
  CLI::App* options =
      app.add_subcommand("calibrate", "Measure camera and hand, with a checkerboard or without");
  const auto run = std::make_shared<CalibrateRun>();
  options->add_option("INPUT", run->input, "The recording, or a camera; else the remembered camera")
      ->type_name(" ");
  options->add_option("--board", run->grid, "Inner corners of the checkerboard, e.g. 8x6");
  options->add_option("--square-mm", run->square_mm, "Side of its squares")
      ->check(between(1.0, 1000.0));
  options->add_option("--camera-out", run->camera_out, "Write the camera (YAML)");
  options->add_option("--hand-out", run->hand_out, "Write the hand (JSON)");
  options
      ->add_option("--picture", run->picture_out,
                   "Write a picture of the result, paper Figure 5 (.png, .jpg)")
      ->check(ends_in({".png", ".jpg"}));
  options
      ->add_option("--camera", run->camera_file, "Known camera (YAML): only the hand is measured")
      ->excludes("--camera-out");
  options->add_option("--method", run->method, "How the hand is measured")
      ->check(CLI::IsMember({"triangulation", "plane"}))
      ->capture_default_str();
  options
      ->add_option("--thickness-mm", run->thickness_mm,
                   "Height of the fingertips above the board, for the paper's way")
      ->check(between(0.0, 50.0))
      ->capture_default_str();
  options->add_flag("--self", run->self, "Without a board: from the hand's own motion")
      ->needs("--camera")
      ->excludes("--board", "--square-mm", "--method", "--thickness-mm");
  options
      ->add_option("--span-mm", run->span_mm,
                   "With --self: thumb tip to little fingertip, as spread in the recording")
      ->needs("--self")
      ->check(between(50.0, 350.0));
  options
      ->add_option("--hand-length-mm", run->hand_length_mm,
                   "With --self: crease of the wrist to tip of the middle finger")
      ->needs("--self")
      ->excludes("--span-mm")
      ->check(between(80.0, 300.0));
  options->add_flag("--show", run->show, "Show what is seen and what is missing; q or Esc ends");
  options->footer(kNotes);
  return {options, [run] {
            run->input = input_of(run->input);
            return calibrate(*run);
          }};
}

}  // namespace handyar::cli
