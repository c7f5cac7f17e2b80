// SPDX-License-Identifier: MIT
#include "handyar/tracker.hpp"

#include <time.h>

#include <algorithm>
#include <cstring>
#include <opencv2/aruco.hpp>

#include "clip.hpp"

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
    for (int i = 0; i < kCount; ++i) state.counters[kNames[i]] = median(ms_[i]);
  }

 private:
  static constexpr int kCount = 6;
  std::vector<double> ms_[kCount];
};

Config config(bool half_resolution) {
  Config config;
  config.half_resolution = half_resolution;
  config.now_s = now_s;
  return config;
}

constexpr double kFrame_s = 1 / 30.0;

/// Frame after frame; those in which the hand is tracked count.
void tracking(benchmark::State& state, bool half_resolution) {
  HandTracker tracker(clip().camera, clip().hand, config(half_resolution));
  Swing swing(static_cast<int>(clip().frames.size()));
  double time_s = 0;
  const auto process_next = [&] {
    return tracker.process(view(clip().frames[swing.next()]), time_s += kFrame_s);
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

/// Each frame as the first one that the tracker sees, so that it looks for the hand anywhere.
void searching(benchmark::State& state, bool half_resolution) {
  HandTracker tracker(clip().camera, clip().hand, config(half_resolution));
  Swing swing(static_cast<int>(clip().frames.size()));
  double time_s = 0;
  Stages stages;
  for (auto _ : state) {
    tracker.reset();
    const ImageView frame = view(clip().frames[swing.next()]);
    const TrackResult result = tracker.process(frame, time_s += kFrame_s);
    state.SetIterationTime(1e-3 * result.times.total_ms);
    stages.add(result.times);
  }
  stages.report(state);
}

/// The marker in the same frames, corners refined, on one thread.
void aruco(benchmark::State& state) {
  cv::setNumThreads(1);
  const auto dictionary = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_50);
  const auto parameters = cv::aruco::DetectorParameters::create();
  parameters->cornerRefinementMethod = cv::aruco::CORNER_REFINE_SUBPIX;
  Swing swing(static_cast<int>(clip().frames.size()));
  std::vector<double> total_ms;
  std::int64_t found = 0;
  for (auto _ : state) {
    const cv::Mat& frame = clip().frames[swing.next()];
    std::vector<std::vector<cv::Point2f>> corners;
    std::vector<int> ids;
    const double start_s = now_s();
    cv::aruco::detectMarkers(frame, dictionary, corners, ids, parameters);
    const double took_s = now_s() - start_s;
    state.SetIterationTime(took_s);
    total_ms.push_back(1e3 * took_s);
    found += !ids.empty();
  }
  state.counters["total"] = median(total_ms);
  state.counters["found"] = static_cast<double>(found) / static_cast<double>(total_ms.size());
}

/// The least that a program which looks at every pixel can take.
void copy_of_the_frame(benchmark::State& state) {
  Swing swing(static_cast<int>(clip().frames.size()));
  cv::Mat copy = clip().frames[0].clone();
  std::vector<double> total_ms;
  for (auto _ : state) {
    const cv::Mat& frame = clip().frames[swing.next()];
    const double start_s = now_s();
    std::memcpy(copy.data, frame.data, frame.total() * frame.elemSize());
    benchmark::ClobberMemory();
    const double took_s = now_s() - start_s;
    state.SetIterationTime(took_s);
    total_ms.push_back(1e3 * took_s);
  }
  state.counters["total"] = median(total_ms);
}

}  // namespace

double now_s() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void register_tracker_benchmarks() {
  const auto add = [](const char* name, const auto& function) {
    benchmark::RegisterBenchmark(name, function)->UseManualTime()->Unit(benchmark::kMillisecond);
  };
  add("tracker/full/searching", [](benchmark::State& s) { searching(s, false); });
  add("tracker/full/tracking", [](benchmark::State& s) { tracking(s, false); });
  add("tracker/half/searching", [](benchmark::State& s) { searching(s, true); });
  add("tracker/half/tracking", [](benchmark::State& s) { tracking(s, true); });
  add("aruco", aruco);
  add("copy", copy_of_the_frame);
}

}  // namespace handyar::benchmarks
