// SPDX-License-Identifier: MIT
#include "tracking_run.hpp"

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <opencv2/core.hpp>
#include <vector>

#include "command.hpp"
#include "diagnosis.hpp"
#include "event_log.hpp"
#include "handyar/io/camera_file.hpp"
#include "handyar/io/error.hpp"
#include "handyar/io/frame_source.hpp"
#include "handyar/io/hand_file.hpp"
#include "handyar/io/pose_csv.hpp"
#include "handyar/io/recording.hpp"
#include "handyar/io/video_writer.hpp"
#include "handyar/opencv/annotate.hpp"
#include "remembered.hpp"
#include "viewer.hpp"

namespace handyar::cli {
namespace {

// What is taken for granted is told once everything could be opened: a fault is then the one line.
using Notes = std::vector<std::string>;

// A camera that was remembered is the one in use, not the one that made some file.
std::string camera_file_of(const TrackingRun& run, const io::SourceInfo& input, Notes& notes) {
  if (!run.camera_file.empty() || !input.live) return run.camera_file;
  const std::string file = remembered().camera_file;
  if (!file.empty()) notes.push_back("no --camera: " + file + " is taken, from handyar setup");
  return file;
}

Camera camera_of(const TrackingRun& run, const io::SourceInfo& input, Notes& notes) {
  const std::string file = camera_file_of(run, input, notes);
  if (file.empty()) {
    notes.push_back("no --camera: a field of view of 60 degrees is assumed");
    return Camera::from_field_of_view(input.width_px, input.height_px);
  }
  const Camera camera = io::read_camera(file);
  if (camera.assumed) notes.push_back(file + ": its field of view is assumed, not calibrated");
  if (camera.width_px == input.width_px && camera.height_px == input.height_px) return camera;
  const Camera scaled = io::camera_for_size(camera, input.width_px, input.height_px, file);
  const auto size = [](const auto& of) {
    return std::to_string(of.width_px) + "x" + std::to_string(of.height_px);
  };
  notes.push_back(file + " is scaled from " + size(camera) + " to " + size(input) + " pixels");
  return scaled;
}

HandModel hand_of(const TrackingRun& run, Notes& notes) {
  if (run.hand_file == "average") return average_adult_hand();
  const std::string file = run.hand_file.empty() ? remembered().hand_file : run.hand_file;
  if (file.empty()) {
    notes.push_back("no --hand: the average adult hand is assumed, and with it the scale");
    return average_adult_hand();
  }
  if (run.hand_file.empty())
    notes.push_back("no --hand: " + file + " is taken, from handyar setup");
  const HandModel hand = io::read_hand(file);
  if (hand.scale_assumed())
    notes.push_back(file + ": the average adult's size is assumed, and with it the scale");
  return hand;
}

AnyTracker make_tracker(const TrackingRun& run, const Camera& camera, const HandModel& hand) {
  if (run.method == Method::paper) {
    paper::Config config = run.paper_config;
    if (run.timings) config.now_s = steady_now_s;
    return paper::Tracker(camera, hand, config);
  }
  Config config = run.config;
  if (run.timings) config.now_s = steady_now_s;
  return HandTracker(camera, hand, config);
}

// Everything a run writes or shows; opened before the first frame is tracked, so that what cannot
// be written is known at once.
struct Outputs {
  std::optional<io::PoseCsvWriter> poses;
  std::optional<io::VideoWriter> video;
  std::optional<EventLog> events;
  std::optional<io::Recording> recording;
  std::optional<Viewer> viewer;
  std::optional<DebugPictures> debug;

  Outputs(const TrackingRun& run, const io::SourceInfo& input) {
    if (!run.poses_out.empty()) poses.emplace(run.poses_out, run.timings);
    if (!run.video_out.empty()) {
      video.emplace(run.video_out, input.width_px, input.height_px, input.fps);
    }
    if (!run.events_out.empty()) events.emplace(run.events_out);
    if (!run.record_out.empty()) recording.emplace(run.record_out, input.width_px, input.height_px);
    if (!run.debug_folder.empty()) debug.emplace(run.debug_folder);
    if (run.show) viewer.emplace(input.width_px, input.height_px, run.annotated, run.mirrored);
  }
  bool pictures() const { return video || viewer; }
  void finish() {
    if (poses) poses->finish();
    if (video) video->finish();
    if (events) events->finish();
    if (recording) recording->finish();
  }
};

std::optional<double> median(std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Frames that were asked for and never came are a fault, unless somebody ended the run.
void require_all_seen(const TrackingRun& run, const Summary& summary) {
  const std::int64_t last = run.debug_frames.last();
  if (run.debug_folder.empty() || last <= summary.last_frame || summary.ended_early) return;
  throw io::Error(run.input, "--debug-frames asks for frame " + std::to_string(last) +
                                 ", the last one is " + std::to_string(summary.last_frame));
}

// Found and lost, grabbed, released and clicked, when the one or the other happens. A hand that
// folds its fingers is not lost.
class Changes {
 public:
  /// `hand`: its number in the log, where there are two; else 0.
  explicit Changes(int hand) : hand_(hand) {}

  void tell(EventLog& log, std::int64_t frame, const TrackResult& result) {
    nlohmann::ordered_json more = nlohmann::ordered_json::object();
    if (hand_ > 0) more["hand"] = hand_;
    if (result.gesture_event) log.write(name(*result.gesture_event), frame, result.time_s, more);
    const bool tracked = result.state == State::tracking || result.held_pose;
    if (tracked == tracked_) return;
    tracked_ = tracked;
    if (tracked && result.layout) more["layout"] = name(*result.layout);
    log.write(tracked ? "found" : "lost", frame, result.time_s, more);
  }

 private:
  int hand_;
  bool tracked_ = false;
};

// A hand that the run follows.
struct TrackedHand {
  AnyTracker tracker;
  Changes changes;
  TrackResult result;

  bool tracked() const { return result.state == State::tracking; }
};

std::vector<TrackedHand> make_hands(const TrackingRun& run, const Camera& camera,
                                    const HandModel& hand) {
  std::vector<TrackedHand> hands;
  for (int i = 0; i < run.hands; ++i)
    hands.push_back({make_tracker(run, camera, hand), Changes(run.hands > 1 ? i + 1 : 0), {}});
  if (run.hands == 2) share_view(hands[0].tracker.figure(), hands[1].tracker.figure());
  return hands;
}

// What is missing, looked at anew every second: for who stands before the camera.
class Hint {
 public:
  const std::string& update(const cv::Mat& bgr, const TrackResult& result,
                            const std::string& hand_file) {
    recent_.look(bgr, result);
    if (result.time_s >= next_s_) {
      next_s_ = result.time_s + 1;
      text_ = recent_.missing(hand_file);
      recent_ = {};
    }
    return text_;
  }

 private:
  Diagnosis recent_;
  std::string text_;
  double next_s_ = 1;
};

// The annotated picture to all who want it; false when the person before it has ended the run.
class Pictures {
 public:
  Pictures(const TrackingRun& run, Outputs& outputs) : run_(run), outputs_(outputs) {}

  bool show(const io::Frame& frame, const std::vector<TrackedHand>& hands, const Camera& camera,
            double wait_s) {
    frame.bgr.copyTo(picture_);
    std::optional<Viewer>& viewer = outputs_.viewer;
    const bool mirrored = viewer ? viewer->mirrored() : run_.mirrored;
    const std::string& missing = hint_.update(frame.bgr, hands[0].result, run_.hand_file);
    if (viewer ? viewer->annotated() : run_.annotated) {
      std::vector<AnnotatedHand> annotated;
      for (const TrackedHand& hand : hands) annotated.push_back({hand.tracker.mask(), hand.result});
      annotate(picture_, annotated, camera, mirrored, missing);
    }
    for (std::size_t i = 0; i < hands.size(); ++i)
      if (const Overlay& draw = run_.overlays[i])
        draw(picture_, frame.index, hands[i].tracker, camera, hands[i].result);
    if (mirrored) cv::flip(picture_, picture_, 1);
    if (outputs_.video) outputs_.video->write(picture_, frame.time_s);
    if (viewer && !viewer->show(picture_, wait_s)) return false;
    if (viewer && viewer->take_next_object() && run_.next_object) run_.next_object();
    return true;
  }

  // The last picture once more, while there is no new one; false when the person has ended it.
  bool show_again() {
    return !outputs_.viewer || picture_.empty() || outputs_.viewer->show(picture_, 0);
  }

 private:
  const TrackingRun& run_;
  Outputs& outputs_;
  Hint hint_;
  cv::Mat picture_;
};

// Shows the frame to each tracker in turn; throws when one refuses it.
void process(std::vector<TrackedHand>& hands, const io::Frame& frame, const std::string& source) {
  for (TrackedHand& hand : hands) {
    hand.result = hand.tracker.process(frame.view(), frame.time_s);
    if (hand.result.status != FrameStatus::ok) {
      throw io::Error(source, "frame " + std::to_string(frame.index) + ": " +
                                  handyar::describe(hand.result.status));
    }
  }
}

void count(const std::vector<TrackedHand>& hands, std::int64_t frame, Summary& summary) {
  ++summary.frames;
  summary.last_frame = frame;
  const auto tracked = std::count_if(hands.begin(), hands.end(),
                                     [](const TrackedHand& hand) { return hand.tracked(); });
  summary.tracked += tracked > 0;
  if (hands.size() == 2) summary.both = summary.both.value_or(0) + (tracked == 2);
}

void write(const io::Frame& frame, std::vector<TrackedHand>& hands, Outputs& outputs) {
  for (std::size_t i = 0; i < hands.size(); ++i) {
    const TrackResult& result = hands[i].result;
    if (outputs.poses) outputs.poses->write(frame.index, result, static_cast<int>(i) + 1);
    if (outputs.events) hands[i].changes.tell(*outputs.events, frame.index, result);
  }
  if (outputs.recording) outputs.recording->write(frame.bgr, frame.time_s);
}

void track_all(const TrackingRun& run, io::FrameSource& source, const Camera& camera,
               std::vector<TrackedHand>& hands, Outputs& outputs, Summary& summary) {
  std::vector<double> times_ms;
  ProgressLine progress;
  io::Frame frame;
  Diagnosis diagnosis;
  Pictures pictures(run, outputs);
  const TrackedHand& first = hands.front();
  const double start_s = steady_now_s();
  const auto until_due_s = [&] {  // a recording is shown at its own pace
    if (!outputs.viewer || source.info().live) return 0.0;
    return start_s + outputs.viewer->paused_s() + frame.time_s - steady_now_s();
  };
  source.ask_while_waiting([&] {
    summary.ended_early |= !pictures.show_again();
    return interrupt() == 0 && !summary.ended_early;
  });
  while (interrupt() == 0 && source.read(frame)) {
    process(hands, frame, source.info().name);
    count(hands, frame.index, summary);
    if (run.timings) {
      double total_ms = 0;
      for (const TrackedHand& hand : hands) total_ms += hand.result.times.total_ms;
      times_ms.push_back(total_ms);
    }
    write(frame, hands, outputs);
    if (outputs.debug && run.debug_frames.contains(frame.index))
      outputs.debug->write(frame.bgr, frame.index, first.tracker, camera, first.result);
    if (run.observer) {
      run.observer(frame.bgr, frame.index, first.tracker, camera, first.result, source.info().live);
    }
    if (summary.tracked == 0) diagnosis.look(frame.bgr, first.result);
    if ((outputs.pictures() || run.overlays[0]) &&
        !pictures.show(frame, hands, camera, until_due_s())) {
      summary.ended_early = true;
      break;
    }
    if (outputs.viewer && outputs.viewer->take_new_hand())
      for (TrackedHand& hand : hands) hand.tracker.reset();
    progress.show(summary.frames, source.info().frame_count,
                  " frames, " + std::to_string(summary.tracked) + " tracked");
  }
  summary.median_ms = median(times_ms);
  if (summary.tracked == 0) summary.missing = diagnosis.missing(run.hand_file);
  summary.signal = interrupt();
  summary.ended_early |= summary.signal != 0;
}

}  // namespace

void add_tracker_files(CLI::App* options, TrackingRun& run) {
  options->add_option("--camera", run.camera_file, "Camera file (YAML); else 60 degrees assumed")
      ->type_name("FILE");
  options
      ->add_option("--readout-ms", run.readout_ms,
                   "Rolling shutter: from the first row's time to the last's; else the camera "
                   "file's, else none")
      ->check(between(0.0, 100.0));
  options
      ->add_option("--hand", run.hand_file, "Hand file (JSON), or average, the average adult hand")
      ->type_name("FILE");
}

void add_video(CLI::App* options, TrackingRun& run, const std::string& what) {
  options->add_option("--video", run.video_out, what + " (.mp4, .mov, .mkv, .avi)")
      ->type_name("FILE")
      ->check(ends_in({".mp4", ".mov", ".mkv", ".avi"}));
}

Summary track(const TrackingRun& run) {
  require_distinct_files({run.input, run.camera_file, run.hand_file},
                         {run.poses_out, run.video_out, run.events_out, run.record_out});
  const std::unique_ptr<io::FrameSource> source = io::open_input(run.input, run.camera_settings);
  Notes notes;
  if (const int by = source->info().reduced_by; by > 1) {
    notes.push_back(source->info().name + " is too large, its sides are divided by " +
                    std::to_string(by) + ": " + std::to_string(source->info().width_px) + "x" +
                    std::to_string(source->info().height_px) + " pixels");
  }
  Camera camera = camera_of(run, source->info(), notes);
  if (run.readout_ms) camera.readout_s = *run.readout_ms / 1000;
  const HandModel hand = hand_of(run, notes);
  catch_interrupts();  // from here on there are files to finish
  Outputs outputs(run, source->info());
  for (const std::string& note : notes) std::cerr << "handyar: " << note << '\n';

  std::vector<TrackedHand> hands = make_hands(run, camera, hand);
  Summary summary;
  summary.live = source->info().live;
  try {
    track_all(run, *source, camera, hands, outputs, summary);
  } catch (const io::Error&) {
    if (summary.frames > 0) outputs.finish();
    throw;
  }
  outputs.finish();
  require_all_seen(run, summary);
  return summary;
}

std::string describe(const Summary& summary) {
  char text[160];
  const auto percent = [&](std::int64_t frames) {
    return summary.frames > 0
               ? 100.0 * static_cast<double>(frames) / static_cast<double>(summary.frames)
               : 0.0;
  };
  const auto rest = [&](int length) { return sizeof text - static_cast<std::size_t>(length); };
  int length = std::snprintf(text, sizeof text, "%lld frame%s, %.1f %% tracked",
                             static_cast<long long>(summary.frames), summary.frames == 1 ? "" : "s",
                             percent(summary.tracked));
  if (summary.both)
    length += std::snprintf(text + length, rest(length), ", %.1f %% with both hands",
                            percent(*summary.both));
  if (summary.median_ms)
    length +=
        std::snprintf(text + length, rest(length), ", median %.2f ms a frame", *summary.median_ms);
  return std::string(text, static_cast<std::size_t>(length)) +
         (summary.signal != 0 && !summary.live ? " (interrupted)" : "") +
         (summary.missing.empty() ? "" : "\n" + summary.missing);
}

int exit_code(const Summary& summary) noexcept {
  return summary.signal != 0 && !summary.live ? 128 + summary.signal : kDone;
}

}  // namespace handyar::cli
