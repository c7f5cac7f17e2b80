// SPDX-License-Identifier: MIT
// Tables 1 to 3 of T. Lee and T. Höllerer, ISWC 2007, and this program's figures beside theirs.
#include <array>
#include <map>

#include "handyar/evaluation/tables.hpp"

namespace handyar::evaluation {
namespace {

struct Stage {
  const char* row;
  double StageTimes::*ms;
  double paper_full_ms, paper_half_ms;  // the paper's 640x480 and 320x240, 1.8 GHz laptop
};

constexpr std::array<Stage, 6> kStages = {{
    {"segmentation", &StageTimes::segmentation_ms, 39.4, 13.2},
    {"fingertips", &StageTimes::fingertips_ms, 14.8, 4.1},
    {"matching", &StageTimes::matching_ms, 0.01, 0.01},
    {"pose", &StageTimes::pose_ms, 0.9, 1.5},
    {"filter", &StageTimes::filter_ms, 0.05, 0.05},
    {"total, hand tracked", &StageTimes::total_ms, 69.8, 22.3},
}};

/// A row's columns for one resolution.
void add_times(Table& t, const std::string& row, const std::string& resolution,
               const std::vector<double>& ms, bool with_rate) {
  const Summary s = summarize(ms);
  t.add(row, resolution + " median", s.median, "ms");
  t.add(row, resolution + " mean", s.mean, "ms");
  t.add(row, resolution + " 95 %", s.p95, "ms");
  t.add(row, resolution + " rate", with_rate ? 1e3 / s.median : kUnknown, "frames/s");
}

std::vector<double> stage_ms(std::span<const Analysis> analyses, const char* method, bool half,
                             double StageTimes::*stage, bool only_tracked) {
  std::vector<double> ms;
  for (const Analysis& a : analyses)
    for (const Track& track : a.recording.tracks) {
      if (track.half_resolution != half || track.method != method) continue;
      for (const TrackResult& r : track.results)
        if (!only_tracked || r.state == State::tracking) ms.push_back(r.times.*stage);
    }
  return ms;
}

std::vector<double> marker_ms(std::span<const Analysis> analyses, bool half,
                              const std::string& system) {
  std::vector<double> ms;
  for (const Analysis& a : analyses)
    if (const MarkerTrack* m = a.recording.find_marker(system, half))
      ms.insert(ms.end(), m->ms.begin(), m->ms.end());
  return ms;
}

void add_row3(Table& t, const std::string& row, const BoardErrors& errors, double paper_px) {
  const Summary blocks = summarize(errors.blocks_px), exact = summarize(errors.exact_px);
  t.add(row, "mean", blocks.mean, "px");
  t.add(row, "variance", blocks.variance, "px²");
  t.add(row, "median", blocks.median, "px");
  t.add(row, "frames", blocks.n);
  t.add(row, "mean, exact transform", exact.mean, "px");
  t.add(row, "variance, exact transform", exact.variance, "px²");
  t.add(row, "frames, exact transform", exact.n);
  t.add(row, "paper mean", paper_px, "px");
  t.add(row, "paper variance", kUnknown, "px²");
}

}  // namespace

Table table1(std::span<const Analysis> analyses, const std::string& sequence) {
  Table t{"table1",
          sequence,
          "Table 1: time a frame",
          "Milliseconds of each stage on this machine, one thread, the paper's method with "
          "ellipses, over the frames in which the hand is tracked; the last rows: every frame, the "
          "default method, which lays a figure on the picture, and over every frame the marker "
          "systems on the same frames in the same run (colour conversion, detection, pose). Full: "
          "the input's size; half: half of it each way. Rate: frames a second at the median. "
          "Paper: 640x480 and 320x240 on a 1.8 GHz laptop of 2007.",
          {}};
  for (const bool half : {false, true}) {
    const std::string resolution = half ? "half" : "full";
    for (const Stage& stage : kStages)
      add_times(t, stage.row, resolution, stage_ms(analyses, kPaper, half, stage.ms, true),
                stage.ms == &StageTimes::total_ms);
    add_times(t, "total, every frame", resolution,
              stage_ms(analyses, kPaper, half, &StageTimes::total_ms, false), true);
    if (!half) {
      add_times(t, "figure, tracking", resolution,
                stage_ms(analyses, kFigure, half, &StageTimes::total_ms, true), true);
      add_times(t, "figure, every frame", resolution,
                stage_ms(analyses, kFigure, half, &StageTimes::total_ms, false), true);
    }
    for (const char* system : {"ArUco", "AprilTag"})
      add_times(t, std::string(system) + ", detection and pose", resolution,
                marker_ms(analyses, half, system), true);
  }
  for (const Stage& stage : kStages) {
    t.add(stage.row, "paper full", stage.paper_full_ms, "ms");
    t.add(stage.row, "paper half", stage.paper_half_ms, "ms");
  }
  return t;
}

Table table2(const Analysis& a) {
  Table t{
      "table2",
      a.recording.sequence.name,
      "Table 2: ways to place a fingertip",
      "Mean reprojection error at the board's inner corners (rms over the corners of a frame, "
      "mean over the frames; hand-to-board fitted on the other half of the frames, alternating "
      "blocks of 15), in pixels of the input at both resolutions. Where truth is known also the "
      "median distance of the fingertips from the true ones.",
      {}};
  const std::map<std::string, double> paper_px = {{kPaperCurvature, 7.96}, {kPaper, 5.76}};
  for (std::size_t i = 0; i < a.tracks.size(); ++i) {
    const Track& track = a.recording.tracks[i];
    const std::string resolution = track.half_resolution ? "half" : "full";
    const std::string& row = track.method;
    if (!a.tracks[i].raw.blocks_px.empty()) {
      t.add(row, resolution + " board, raw pose", summarize(a.tracks[i].raw.blocks_px).mean, "px");
      t.add(row, resolution + " board, filtered", summarize(a.tracks[i].filtered.blocks_px).mean,
            "px");
    }
    if (a.has_truth())
      t.add(row, resolution + " fingertips, median", summarize(a.tracks[i].errors).tip_px.median,
            "px");
    if (!track.half_resolution && a.has_board()) {  // the paper's are errors at the board
      const auto known = paper_px.find(track.method);
      t.add(row, "paper full", known == paper_px.end() ? kUnknown : known->second, "px");
      t.add(row, "paper half", kUnknown, "px");
    }
  }
  return t;
}

Table table3(const Analysis& a) {
  Table t{
      "table3",
      a.recording.sequence.name,
      "Table 3: hand against markers",
      "Reprojection error at the board's inner corners, full resolution: rms over the corners of "
      "a frame, its mean and variance over the frames. The transforms from hand and markers to "
      "the board are fitted on alternating blocks of 15 frames and judged on the blocks between, "
      "and the other way round. Exact transform: the true one instead of a fitted one, and the "
      "true corners (then a wrong size of a marker's edge, as bloom makes it, shows); of the hand "
      "only frames that are eligible and rightly tracked. The paper's marker was ARTag.",
      {}};
  if (!a.has_board()) return t;
  constexpr double kPaperFingertips_px = 5.86, kPaperMarker_px = 4.79;
  add_row3(t, "figure, raw", a.main_track().raw, kUnknown);
  add_row3(t, "figure, filtered", a.main_track().filtered, kUnknown);
  for (std::size_t i = 0; i < a.tracks.size(); ++i)
    if (a.recording.tracks[i].method == kPaper && !a.recording.tracks[i].half_resolution)
      add_row3(t, "paper, filtered", a.tracks[i].filtered, kPaperFingertips_px);
  for (std::size_t i = 0; i < a.markers.size(); ++i)
    if (!a.recording.markers[i].half_resolution)
      add_row3(t, a.recording.markers[i].system, a.markers[i], kPaperMarker_px);
  add_row3(t, "checkerboard itself", {a.own_px, {}}, kUnknown);
  return t;
}

}  // namespace handyar::evaluation
