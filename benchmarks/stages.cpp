// SPDX-License-Identifier: MIT
//
// Each stage alone, on the last frame of the clip.
#include "clip.hpp"
#include "handyar/pose_filter.hpp"
#include "handyar/stages/align.hpp"
#include "handyar/stages/hand_finder.hpp"
#include "handyar/tracker.hpp"

namespace handyar::benchmarks {
namespace {

/// The clip's end as the tracker sees it.
struct Scene {
  const cv::Mat& picture = clip().frames.back();
  TrackResult result;
  HandState state;
  Appearance appearance;
  HandPrior prior;
  Aligner aligner;
};

Scene make_scene() {
  Scene s;
  HandTracker tracker(clip().camera, clip().hand);
  double time_s = 0;
  for (const cv::Mat& frame : clip().frames)
    s.result = tracker.process(view(frame), time_s += 0.03);
  if (!s.result.raw_pose) return s;
  s.state.T_camera_hand = s.result.raw_pose->T_camera_hand;
  s.state.figure = estimate_figure(tracker.hand()).mean;
  s.appearance = {*s.result.face, *s.result.layout};
  s.prior.mean = s.state;
  s.prior.information *= 100;
  s.aligner.learn(view(s.picture), clip().camera, s.appearance, s.state, 0, kNearSteps.coarsest);
  return s;
}

/// Null, with the reason given, when the clip does not end with a tracked hand.
Scene* scene(benchmark::State& state) {
  static Scene scene = make_scene();
  if (scene.result.raw_pose) return &scene;
  state.SkipWithError("the clip does not end with a tracked hand");
  return nullptr;
}

void look(benchmark::State& state) {
  const cv::Mat& picture = clip().frames.back();
  HandFinder finder;
  const FinderRegion whole{{0.5f * picture.cols, 0.5f * picture.rows},
                           static_cast<float>(picture.cols)};
  for (auto _ : state) benchmark::DoNotOptimize(finder.look(view(picture), whole).data());
}

void align(benchmark::State& state) {
  Scene* s = scene(state);
  if (s == nullptr) return;
  for (auto _ : state)
    benchmark::DoNotOptimize(s->aligner.align(view(s->picture), clip().camera, s->appearance,
                                              s->state, s->prior, kNearSteps));
}

void learn(benchmark::State& state) {
  Scene* s = scene(state);
  if (s == nullptr) return;
  for (auto _ : state) {
    s->aligner.learn(view(s->picture), clip().camera, s->appearance, s->state, 0.8f,
                     kNearSteps.finest);
    benchmark::ClobberMemory();
  }
}

void filter_pose(benchmark::State& state) {
  const Scene* s = scene(state);
  if (s == nullptr) return;
  PoseFilter filter;
  double time_s = 0;
  for (auto _ : state) {
    filter.update(time_s += 1 / 30.0, *s->result.raw_pose);
    benchmark::DoNotOptimize(filter.predict(time_s));
  }
}

}  // namespace

void register_stage_benchmarks() {
  const auto add = [](const char* name, const auto& function) {
    benchmark::RegisterBenchmark(name, function)->Unit(benchmark::kMicrosecond);
  };
  add("stage/find/look", look);
  add("stage/align", align);
  add("stage/learn", learn);
  add("stage/filter", filter_pose);
}

}  // namespace handyar::benchmarks
