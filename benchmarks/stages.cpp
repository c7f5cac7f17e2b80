// SPDX-License-Identifier: MIT
//
// Each stage alone, on the last frame of the clip.
#include <array>
#include <optional>

#include "clip.hpp"
#include "handyar/contour.hpp"
#include "handyar/hand_search.hpp"
#include "handyar/matching.hpp"
#include "handyar/skin_model.hpp"
#include "handyar/tracker.hpp"

namespace handyar::benchmarks {
namespace {

/// The clip's end as the tracker sees it, for the stages after segmentation.
struct Scene {
  const cv::Mat& picture = clip().frames.back();
  TrackResult result;
  Mask mask;
  Contour contour;
  Eigen::Vector2f palm = Eigen::Vector2f::Zero();
  float palm_radius = 0;
  BinImage bins;
};

Scene make_scene() {
  Scene s;
  HandTracker tracker(clip().camera, clip().hand);
  double time_s = 0;
  for (const cv::Mat& frame : clip().frames)
    s.result = tracker.process(view(frame), time_s += 0.03);

  const HandMask seen = tracker.mask();
  s.mask.pack(seen.data, seen.width, seen.height, seen.stride_bytes);
  s.contour.reserve(1 << 14);
  if (!s.contour.trace(s.mask)) return s;
  const auto& tips = s.result.tips;
  s.palm_radius = static_cast<float>(0.23 * (tips[0].px - tips[4].px).norm());
  s.palm = 0.5f * (s.result.valleys[0].px + s.result.valleys[3].px).cast<float>();
  const int pixels = s.picture.rows * s.picture.cols;
  s.bins.bins.resize(static_cast<std::size_t>(pixels));
  read_bins(view(s.picture), {0, 0, s.picture.cols, s.picture.rows}, 1, s.bins);
  return s;
}

/// Null, with the reason given, when the clip does not end with a tracked hand.
const Scene* scene(benchmark::State& state) {
  static const Scene scene = make_scene();
  if (scene.result.state == State::tracking && scene.contour.size() > 0) return &scene;
  state.SkipWithError("the clip does not end with a tracked hand");
  return nullptr;
}

void read_colors(benchmark::State& state, int step_px) {
  const cv::Mat& picture = clip().frames.back();
  BinImage out;
  out.bins.resize(static_cast<std::size_t>(picture.rows) * picture.cols);
  for (auto _ : state) {
    read_bins(view(picture), {0, 0, picture.cols, picture.rows}, step_px, out);
    benchmark::ClobberMemory();
  }
}

void classify_and_label(benchmark::State& state) {
  const Scene* s = scene(state);
  if (s == nullptr) return;
  const SkinModel skin;
  RegionFinder region;
  region.reserve(s->bins.width * s->bins.height);
  for (auto _ : state) {
    region.classify(s->bins, skin.ratios(), ExpectedRegion{});
    benchmark::DoNotOptimize(region.components(500).data());
  }
}

void learn_skin(benchmark::State& state) {
  const Scene* s = scene(state);
  if (s == nullptr) return;
  SkinModel skin;
  const auto bins = s->bins.used();
  for (auto _ : state) skin.learn(bins.first(4096), bins.last(4096));
}

void search_whole_frame(benchmark::State& state) {
  const cv::Mat& picture = clip().frames.back();
  MaskStages stages;
  HandSearch search(stages);
  BinImage bins;
  bins.bins.resize(static_cast<std::size_t>(picture.rows) * picture.cols / 4);
  read_bins(view(picture), {0, 0, picture.cols, picture.rows}, 2, bins);
  stages.reserve(bins.width * bins.height);
  search.reserve(bins.width * bins.height);
  const SkinModel skin;
  HandShape shape;
  for (auto _ : state) benchmark::DoNotOptimize(search.find(bins, skin, shape));
}

void trace_contour(benchmark::State& state) {
  const Scene* s = scene(state);
  if (s == nullptr) return;
  Contour contour;
  contour.reserve(1 << 14);
  for (auto _ : state) benchmark::DoNotOptimize(contour.trace(s->mask));
}

void find_curvature(benchmark::State& state) {
  const Scene* s = scene(state);
  if (s == nullptr) return;
  CurvatureFinder finder;
  for (auto _ : state) {
    finder.find(s->contour, s->palm_radius);
    benchmark::ClobberMemory();
  }
}

void measure_five_tips(benchmark::State& state, FingertipMethod method) {
  const Scene* s = scene(state);
  if (s == nullptr) return;
  CurvatureFinder finder;
  finder.find(s->contour, s->palm_radius);
  for (auto _ : state)
    for (const Extremum& tip : finder.tips())
      benchmark::DoNotOptimize(measure_tip(s->contour,
                                           static_cast<float>(tip.sample) * finder.spacing(),
                                           s->palm, 0.45f * s->palm_radius, method));
}

void match(benchmark::State& state) {
  const Scene* s = scene(state);
  if (s == nullptr) return;
  CurvatureFinder finder;
  finder.find(s->contour, s->palm_radius);
  std::array<Eigen::Vector2f, CurvatureFinder::kMaxTips> candidates;
  for (std::size_t i = 0; i < finder.tips().size(); ++i) candidates[i] = finder.tips()[i].at;
  std::array<Eigen::Vector2f, kFingerCount> previous;
  for (int f = 0; f < kFingerCount; ++f) previous[f] = s->result.tips[f].px.cast<float>();
  for (auto _ : state)
    benchmark::DoNotOptimize(
        match_tips(previous, {candidates.data(), finder.tips().size()}, *s->result.layout, 100.0f));
}

void pose(benchmark::State& state) {
  const Scene* s = scene(state);
  if (s == nullptr) return;
  HandObservation observation;
  for (int f = 0; f < kFingerCount; ++f)
    observation.tips[f] = {s->result.tips[f].px, 0.8, s->result.tips[f].seen};
  const HandModel hand = clip().hand.for_layout(*s->result.layout);
  for (auto _ : state) benchmark::DoNotOptimize(estimate_pose(observation, hand, clip().camera));
}

void filter_pose(benchmark::State& state) {
  const Scene* s = scene(state);
  if (s == nullptr || !s->result.raw_pose) return;
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
  add("stage/read_bins/full", [](benchmark::State& s) { read_colors(s, 1); });
  add("stage/read_bins/half", [](benchmark::State& s) { read_colors(s, 2); });
  add("stage/classify_and_label", classify_and_label);
  add("stage/learn_skin", learn_skin);
  add("stage/search_whole_frame", search_whole_frame);
  add("stage/trace_contour", trace_contour);
  add("stage/curvature", find_curvature);
  add("stage/tips/curvature",
      [](benchmark::State& s) { measure_five_tips(s, FingertipMethod::curvature); });
  add("stage/tips/ellipse",
      [](benchmark::State& s) { measure_five_tips(s, FingertipMethod::ellipse); });
  add("stage/match", match);
  add("stage/pose", pose);
  add("stage/filter", filter_pose);
}

}  // namespace handyar::benchmarks
