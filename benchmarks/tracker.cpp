// SPDX-License-Identifier: MIT
#include "handyar/tracker.hpp"

#include <time.h>

#include <algorithm>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <string>

#include "clip.hpp"
#include "handyar/opencv/aruco.hpp"
#include "handyar/paper/tracker.hpp"
#include "handyar/world/world_tracker.hpp"

namespace handyar::benchmarks {
namespace {

/// Frames forwards, then backwards, and so on: a hand that never jumps.
class Swing {
 public:
  explicit Swing(int count) : count_(count) {}
  int next() {
    const int at = at_;
    if (at_ + step_ < 0 || at_ + step_ >= count_) step_ = -step_;
    at_ += step_;
    return at;
  }

 private:
  int count_, at_ = 0, step_ = 1;
};

/// Medians of what the stages took, as counters of the benchmark.
class Stages {
 public:
  void add(const StageTimes& t) {
    const double ms[kCount] = {t.segmentation_ms, t.fingertips_ms, t.matching_ms,
                               t.pose_ms,         t.filter_ms,     t.total_ms};
    for (int i = 0; i < kCount; ++i) ms_[i].push_back(ms[i]);
  }
  void report(benchmark::State& state) {
    static constexpr const char* kNames[kCount] = {"segmentation", "fingertips", "matching",
                                                   "pose",         "filter",     "total"};
    if (ms_[0].empty()) return state.SkipWithError("no frame was in the wanted state");
    for (int i = 0; i < kCount; ++i) state.counters[kNames[i]] = quantile(ms_[i], 0.5);
    state.counters["p99"] = quantile(ms_[kCount - 1], 0.99);
  }

 private:
  static constexpr int kCount = 6;
  std::vector<double> ms_[kCount];
};

constexpr double kFrame_s = 1 / 30.0;

HandTracker figure(const Clip& film) {
  Config config;
  config.now_s = now_s;
  return {film.camera, film.hand, config};
}

paper::Tracker paper(const Clip& film, bool half_resolution) {
  paper::Config config;
  config.half_resolution = half_resolution;
  config.now_s = now_s;
  return {film.camera, film.hand, config};
}

/// Frame after frame; those in which the hand is tracked count.
template <class Tracker>
void tracking(benchmark::State& state, const Clip& film, Tracker tracker) {
  Swing swing(static_cast<int>(film.frames.size()));
  double time_s = 0;
  const auto process_next = [&] {
    return tracker.process(view(film.frames[swing.next()]), time_s += kFrame_s);
  };
  for (int tries = 0; tries < 60 && process_next().state != State::tracking;) ++tries;
  Stages stages;
  for (auto _ : state) {
    const TrackResult result = process_next();
    state.SetIterationTime(1e-3 * result.times.total_ms);
    if (result.state == State::tracking) stages.add(result.times);
  }
  stages.report(state);
}

/// Each frame as the first one that the tracker sees.
void finding(benchmark::State& state, const Clip& film) {
  HandTracker tracker = figure(film);
  Swing swing(static_cast<int>(film.frames.size()));
  double time_s = 0;
  Stages stages;
  for (auto _ : state) {
    tracker.reset();
    const ImageView frame = view(film.frames[swing.next()]);
    const TrackResult result = tracker.process(frame, time_s += kFrame_s);
    state.SetIterationTime(1e-3 * result.times.total_ms);
    stages.add(result.times);
  }
  stages.report(state);
}

/// The frames blurred until they show no hand, but something to look at.
void searching(benchmark::State& state, const Clip& film) {
  HandTracker tracker = figure(film);
  std::vector<cv::Mat> rooms;
  for (std::size_t i = 0; i < film.frames.size(); i += 10) {
    cv::Mat room;
    cv::GaussianBlur(film.frames[i], room, {}, film.frames[i].rows / 12.0);
    rooms.push_back(room);
  }
  double time_s = 0;
  std::size_t at = 0;
  Stages stages;
  for (auto _ : state) {
    const TrackResult result =
        tracker.process(view(rooms[at++ % rooms.size()]), time_s += kFrame_s);
    state.SetIterationTime(1e-3 * result.times.total_ms);
    if (result.state == State::searching) stages.add(result.times);
  }
  stages.report(state);
}

/// Hand and world together, mapping on a thread of its own; frames in which the hand is tracked in
/// a world that it has set count.
void world(benchmark::State& state, const Clip& film) {
  cv::setNumThreads(1);
  HandTracker hands = figure(film);
  world::WorldTracker worlds(film.camera, world::Mapping::background);
  Swing swing(static_cast<int>(film.frames.size()));
  double time_s = 0;
  const auto process_next = [&] {
    const cv::Mat& frame = film.frames[swing.next()];
    const TrackResult hand = hands.process(view(frame), time_s += kFrame_s);
    return worlds.process(frame, time_s, world::HandInWorld::of(hands, hand)).state;
  };
  for (int tries = 0; tries < 60 && process_next() != world::WorldState::tracked;) ++tries;
  std::vector<double> total_ms;
  for (auto _ : state) {
    const double start_s = now_s();
    const world::WorldState seen = process_next();
    const double took_s = now_s() - start_s;
    state.SetIterationTime(took_s);
    if (seen == world::WorldState::tracked) total_ms.push_back(1e3 * took_s);
  }
  if (total_ms.empty()) return state.SkipWithError("the world was never tracked");
  state.counters["total"] = quantile(total_ms, 0.5);
  state.counters["p99"] = quantile(total_ms, 0.99);
}

/// Median time of a function of a frame.
template <class Function>
void time_frames(benchmark::State& state, const Clip& film, const Function& function) {
  Swing swing(static_cast<int>(film.frames.size()));
  std::vector<double> total_ms;
  for (auto _ : state) {
    const cv::Mat& frame = film.frames[swing.next()];
    const double start_s = now_s();
    function(frame);
    benchmark::ClobberMemory();
    const double took_s = now_s() - start_s;
    state.SetIterationTime(took_s);
    total_ms.push_back(1e3 * took_s);
  }
  state.counters["total"] = quantile(total_ms, 0.5);
}

/// The marker in the same frames, corners refined, on one thread.
void aruco(benchmark::State& state, const Clip& film) {
  cv::setNumThreads(1);
  const int dictionary = *dictionary_number("DICT_4X4_50");
  std::int64_t found = 0;
  time_frames(state, film,
              [&](const cv::Mat& frame) { found += !detect_markers(frame, dictionary).empty(); });
  state.counters["found"] = static_cast<double>(found) / static_cast<double>(state.iterations());
}

/// The least that a program which looks at every pixel can take.
void copy_of_the_frame(benchmark::State& state, const Clip& film) {
  cv::Mat copy = film.frames[0].clone();
  time_frames(state, film, [&](const cv::Mat& frame) {
    std::memcpy(copy.data, frame.data, frame.total() * frame.elemSize());
  });
}

}  // namespace

double now_s() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double quantile(std::vector<double>& values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

void register_tracker_benchmarks() {
  const auto add = [](const std::string& name, const auto& function) {
    benchmark::RegisterBenchmark(name.c_str(), function)
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond);
  };
  using Run = benchmark::State;
  add("paper/full", [](Run& s) { tracking(s, clip(), paper(clip(), false)); });
  add("paper/half", [](Run& s) { tracking(s, clip(), paper(clip(), true)); });
  for (const auto& [w, h] : {std::pair{640, 480}, {1280, 720}, {1920, 1080}}) {
    const std::string size = std::to_string(w) + "x" + std::to_string(h);
    const auto film = [w = w, h = h]() -> const Clip& {
      return h == clip().frames[0].rows ? clip() : clip_at(w, h);
    };
    add(size + "/searching", [film](Run& s) { searching(s, film()); });
    add(size + "/finding", [film](Run& s) { finding(s, film()); });
    add(size + "/tracking", [film](Run& s) { tracking(s, film(), figure(film())); });
    add(size + "/world", [film](Run& s) { world(s, film()); });
    add(size + "/aruco", [film](Run& s) { aruco(s, film()); });
    add(size + "/copy", [film](Run& s) { copy_of_the_frame(s, film()); });
  }
}

}  // namespace handyar::benchmarks
