// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "annotate.hpp"
#include "command.hpp"
#include "handyar/io/error.hpp"
#include "handyar/io/frame_source.hpp"
#include "handyar/io/pending_file.hpp"
#include "handyar/io/skin_file.hpp"
#include "handyar/render/window.hpp"

namespace handyar::cli {
namespace {

constexpr const char* kNotes =
    "Hold an open hand before the camera, fingers spread, bare or in a glove of any plain colour,\n"
    "until it has been tracked for a second. It is found by its shape; before a plain background\n"
    "of another colour that is easiest.\n\n"
    "Examples:\n"
    "  handyar learn-color 0 --show --out skin.json\n"
    "  handyar track 0 --skin skin.json --show";

constexpr double kMaxStep_s = 0.1;  // a frame stands for no longer than this
constexpr double kEnough = 0.5;     // share of --seconds that a recording must at least give
constexpr float kSmallestShare = 1e-4f;
constexpr double kForEver = std::numeric_limits<double>::infinity();
constexpr double kFoundAgain = 0.5;  // share of the time that learned colours must track it

struct LearnRun {
  std::string input, out;
  double seconds = 1;
  bool show = false;
};

/// The mean over frames of what the tracker has learned in each.
class ColorCollector {
 public:
  void add(const SkinColors& colors) {
    for (const SkinColors::Entry& e : colors.entries) sum_[e.bin] += e.share;
    ++frames_;
  }
  SkinColors colors() const {
    SkinColors mean;
    for (int i = 0; i < kBinCount; ++i) {
      const float share = sum_[i] / static_cast<float>(std::max(frames_, 1));
      if (share >= kSmallestShare) mean.entries.push_back({static_cast<ColorBin>(i), share});
    }
    return mean;
  }

 private:
  std::vector<float> sum_ = std::vector<float>(kBinCount);
  int frames_ = 0;
};

std::string seconds(double s) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f s", s);
  return text;
}

/// Tracks a hand until it has been for `wanted_s`, for `most_s` at most, and says how long it was.
/// `known`: its colours, where they are known; `learn` gathers them.
double track(io::FrameSource& source, std::optional<render::Window>& window, double wanted_s,
             double most_s, const SkinColors& known, ColorCollector* learn) {
  // Colours need no pose: camera and hand only have to be about right.
  const io::SourceInfo& info = source.info();
  const Camera camera = Camera::from_field_of_view(info.width_px, info.height_px);
  Config config;
  config.skin.personal = known;
  HandTracker tracker(camera, average_adult_hand(), config);
  io::Frame frame;
  cv::Mat picture;
  double tracked_s = 0, before_s = 0, watched_s = 0;
  while (tracked_s < wanted_s && watched_s < most_s && interrupt() == 0 && source.read(frame)) {
    const TrackResult result = tracker.process(frame.view(), frame.time_s);
    if (result.status != FrameStatus::ok) throw io::Error(info.name, describe(result.status));
    const double step_s = std::clamp(frame.time_s - before_s, 0.0, kMaxStep_s);
    watched_s += step_s;
    if (result.state == State::tracking) {
      if (learn) learn->add(tracker.learned_colors());
      tracked_s += step_s;
    }
    before_s = frame.time_s;
    if (!window) continue;
    frame.bgr.copyTo(picture);
    annotate(picture, tracker, camera, result);
    if (!window->show(picture, 0.001)) break;
  }
  return tracked_s;
}

int learn_color(const LearnRun& run) {
  require_distinct_files({run.input}, {run.out});
  std::unique_ptr<io::FrameSource> source = io::open_input(run.input);
  const io::SourceInfo info = source->info();
  io::require_writable(run.out);
  std::optional<render::Window> window;
  if (run.show) window.emplace(info.width_px, info.height_px, "handyar learn-color");
  catch_interrupts();

  ColorCollector collector;
  const double tracked_s = track(*source, window, run.seconds, kForEver, {}, &collector);
  if (interrupt() != 0 && !info.live) return 128 + interrupt();
  if (tracked_s < kEnough * run.seconds)
    throw io::Error(info.name, "an open hand was tracked for " + seconds(tracked_s) +
                                   ", at least half of the " + seconds(run.seconds) +
                                   " of --seconds are needed");
  const SkinColors colors = collector.colors();
  // Colours that do not find the hand they were learned from are of no use.
  if (!info.live) source = io::open_input(run.input);
  const double again_s =
      track(*source, window, tracked_s, info.live ? 3 * tracked_s : kForEver, colors, nullptr);
  if (again_s < kFoundAgain * tracked_s)
    throw io::Error(info.name, "the colours learned from " + seconds(tracked_s) +
                                   " of a tracked hand find it for " + seconds(again_s) +
                                   " only: try another background or more light");
  io::write_skin(run.out, colors);
  std::cout << run.out << ": " << colors.entries.size() << " colours from " << seconds(tracked_s)
            << " of a tracked hand\n";
  return kDone;
}

}  // namespace

Command add_learn_color(CLI::App& app) {
  CLI::App* options = app.add_subcommand(
      "learn-color", "Learn the colours of a hand or a glove from a second of it");
  const auto run = std::make_shared<LearnRun>();
  options->add_option("INPUT", run->input, "A video file, pictures, a camera, or sample")
      ->required();
  options->add_option("--out", run->out, "Write the colours (JSON), for --skin")
      ->required()
      ->type_name("FILE");
  options->add_option("--seconds", run->seconds, "How long the hand is to be tracked")
      ->check(between(0.2, 600.0))
      ->capture_default_str();
  options->add_flag("--show", run->show, "Show it in a window; q or Esc ends");
  options->footer(kNotes);
  return {options, [run] { return learn_color(*run); }};
}

}  // namespace handyar::cli
