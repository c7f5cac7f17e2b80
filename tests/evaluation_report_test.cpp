// SPDX-License-Identifier: MIT
// The whole evaluation on the sequences that ship with the project: bounds on its figures, and the
// report that comes of it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <regex>

#include "evaluation_files.hpp"
#include "handyar/evaluation/footage.hpp"
#include "handyar/evaluation/pictures.hpp"
#include "handyar/evaluation/report.hpp"
#include "handyar/io/frame_source.hpp"

namespace handyar::evaluation {
namespace {

const Analysis& compare_sequence() {
  static const Analysis a = analyse(record(open_sequence(shipped("compare"), {}), Methods::all));
  return a;
}

TEST(ShippedSequences, MarkerBaselinesAgreeWithAnIndependentRun) {
  const Table t = table3(compare_sequence());
  // OpenCV and AprilTag called from Python on the same pictures.
  EXPECT_NEAR(value_of(t, "ArUco", "mean, exact transform"), 2.6, 0.25);
  EXPECT_NEAR(value_of(t, "AprilTag", "mean, exact transform"), 3.0, 0.25);
  EXPECT_LT(value_of(t, "checkerboard itself", "mean"), 0.25);
  // A fitted transform takes up part of what the bloom of the marker's edges does.
  EXPECT_LT(value_of(t, "ArUco", "mean"), 2.6);
  EXPECT_LT(value_of(t, "AprilTag", "mean"), 3.0);
}

TEST(ShippedSequences, CompareIsTrackedAndAccurate) {
  const Accuracy a = summarize(compare_sequence().main_track().errors);
  EXPECT_GE(a.tracked_percent(), 95);
  EXPECT_LE(a.wrong_percent(), 1);
  EXPECT_EQ(a.falsely_tracked, 0);
  EXPECT_LE(a.tip_px.median, 1.5);
}

TEST(ShippedSequences, SampleIsTrackedNoWorseThanBefore) {
  const Sequence s = open_sequence(shipped("sample"), {});
  HandTracker tracker(s.camera, s.hand);
  std::vector<TrackResult> track;
  io::Frame frame;
  for (const auto source = io::open_input(s.video); source->read(frame);)
    track.push_back(tracker.process(frame.view(), frame.time_s));
  const Accuracy a = summarize(compare(*s.truth, s.hand, track));
  EXPECT_GE(a.tracked_percent(), 95);
  EXPECT_LE(a.wrong_percent(), 1);
  EXPECT_EQ(a.falsely_tracked, 0);
  EXPECT_LE(a.tip_px.median, 1.5);
}

TEST(Report, EveryNumberIsARowOfTheCsv) {
  const TemporaryFolder folder;
  write_report(folder / "report", {"handyar evaluate", "0"}, {compare_sequence()}, {});
  const std::vector<std::string> rows = lines_of(folder / "report/tables.csv");
  const std::string page = text_of(folder / "report/report.html");
  const std::regex cell("<td title=\"tables.csv, line (\\d+)\">([^<]*)");
  std::map<int, std::string> shown;
  for (std::sregex_iterator i(page.begin(), page.end(), cell), end; i != end; ++i)
    EXPECT_TRUE(shown.emplace(std::stoi((*i)[1]), (*i)[2]).second) << "two cells, one row";
  EXPECT_EQ(shown.size() + 1, rows.size());
  for (const auto& [line, text] : shown) {
    const std::string& row = rows.at(std::size_t(line) - 1);
    const std::size_t unit = row.rfind(','), value = row.rfind(',', unit - 1);
    const std::string number = row.substr(value + 1, unit - value - 1);
    if (number.empty()) {
      EXPECT_EQ(text, "–") << row;
    } else {
      const double exact = std::stod(number);
      EXPECT_NEAR(std::stod(text), exact, std::max(0.0051, 0.051 * std::abs(exact))) << row;
    }
  }
  EXPECT_EQ(lines_of(folder / "report/errors.csv").size(), 91u) << "a header and 90 frames";
  EXPECT_EQ(lines_of(folder / "report/poses/compare.csv").size(), 91u);
}

TEST(Report, OpensOffline) {
  const TemporaryFolder folder;
  write_report(folder / "report", {"handyar evaluate", "0"}, {compare_sequence()}, {});
  const std::string page = text_of(folder / "report/report.html");
  EXPECT_EQ(page.find("{{"), std::string::npos) << "a place that nothing was put into";
  const std::regex from_elsewhere("(src|href)=\"(?!data:|#)");
  EXPECT_FALSE(std::regex_search(page, from_elsewhere));
  EXPECT_NE(page.find("Permission is hereby granted"), std::string::npos)
      << "the charting library's licence goes with it";
}

TEST(Report, SameInputSameFigures) {
  const TemporaryFolder folder;
  const Analysis again = analyse(record(open_sequence(shipped("compare"), {}), Methods::all));
  const std::regex time(",table1,|,time,");
  std::vector<std::string> rows[2];
  for (int i = 0; i < 2; ++i) {
    const std::string report = folder / ("report" + std::to_string(i));
    write_report(report, {"handyar evaluate", "0"}, {i ? again : compare_sequence()}, {});
    for (const std::string& row : lines_of(report + "/tables.csv"))
      if (!std::regex_search(row, time)) rows[i].push_back(row);
  }
  EXPECT_GT(rows[0].size(), 100u);
  EXPECT_EQ(rows[0], rows[1]);
}

TEST(Report, OfAnEarlierOneNothingStays) {
  const TemporaryFolder folder;
  const std::string report = folder / "report";
  const auto there = [&](const std::string& name) { return fs::exists(fs::path(report) / name); };
  const auto write = [&](const std::string& name, const std::string& text) {
    std::ofstream(fs::path(report) / name) << text;
  };
  Analysis named = compare_sequence();
  named.recording.sequence.name = "with \"quotes\", and a comma";
  const StillResult still{StillResult::Outcome::not_found, "a.jpg", "a", "", kUnknown, {}};
  write_report(report, {"handyar evaluate", "0"}, {named}, {still});
  ASSERT_TRUE(there("poses/" + named.recording.sequence.name + ".csv") && there("stills.csv"));
  write("figure8-" + named.recording.sequence.name + ".png", "as gnuplot draws it");
  write("figure8-other.png", "of the person");
  write("poses/other.csv", "of the person");

  FootageFigures clip;
  clip.name = "clip";
  write_distribution(report, {clip, clip});
  for (const char* of_the_program :
       {"report.html", "tables.csv", "tables.md", "errors.csv", "stills.csv"})
    EXPECT_FALSE(there(of_the_program)) << of_the_program;
  EXPECT_TRUE(fs::exists(report + "/poses/other.csv") && there("figure8-other.png"));
  EXPECT_EQ(std::distance(fs::directory_iterator(report + "/poses"), fs::directory_iterator()), 1);
  EXPECT_FALSE(there("figure8-" + named.recording.sequence.name + ".png"));
  ASSERT_TRUE(there("sequences.csv") && there("worst-2.jpg"));

  write_distribution(report, {clip});
  EXPECT_TRUE(there("worst-1.jpg"));
  EXPECT_FALSE(there("worst-2.jpg"));
  write("stills.csv", "file,thumb_x,thumb_y\n");
  write_report(report, {"handyar evaluate", "0"}, {compare_sequence()}, {});
  EXPECT_FALSE(there("sequences.csv") || there("distribution.md") || there("worst-1.jpg"));
  EXPECT_EQ(text_of(report + "/stills.csv"), "file,thumb_x,thumb_y\n") << "a person's own list";
}

TEST(Report, AClipOfWhichNothingIsKnownSaysSo) {
  const TemporaryFolder folder;
  Recording r;
  r.sequence = open_sequence(shipped("compare") + "/video.mp4", {});
  r.sequence.name = "own <clip>";
  r.tracks.push_back({"ellipse", false, std::vector<TrackResult>(10)});
  for (int i = 0; i < 10; ++i) {
    r.frame_index.push_back(2 * i);  // every other picture of a series is missing
    r.time_s.push_back(2 * i / 30.0);
  }
  r.contours_px.resize(10);
  r.board_views.resize(10);
  const Analysis a = analyse(r);
  EXPECT_GE(a.unknown.size(), 4u) << "truth, camera, hand, board";
  write_report(folder / "report", {"handyar evaluate", "0"}, {a}, {});
  const std::string page = text_of(folder / "report/report.html");
  EXPECT_NE(page.find("What cannot be said"), std::string::npos);
  EXPECT_NE(page.find("own &lt;clip&gt;"), std::string::npos);
  EXPECT_EQ(page.find("Table 3"), std::string::npos);
  EXPECT_EQ(lines_of(folder / "report/poses/own <clip>.csv").back().rfind("18,", 0), 0u);
  EXPECT_EQ(lines_of(folder / "report/errors.csv").back().rfind("own <clip>,18,", 0), 0u);
}

TEST(Report, WhyTheBoardTellsNothingOfTheHandIsSaid) {
  Recording r = compare_sequence().recording;
  const auto told = [](const Recording& recording) {
    const std::vector<std::string> unknown = analyse(recording).unknown;
    return std::count_if(unknown.begin(), unknown.end(), [](const std::string& line) {
      return line.find("seen together in too few frames") != std::string::npos;
    });
  };
  EXPECT_EQ(told(r), 0);
  for (std::size_t i = 15; i < r.board_views.size(); ++i) r.board_views[i].reset();
  EXPECT_EQ(told(r), 1) << "one block of frames does not judge itself";
}

TEST(Report, AMarkersSizeThatWasGivenIsSaidToBe) {
  Recording r = compare_sequence().recording;
  const auto told = [&](const char* system) {
    const std::string line = std::string("The size of the ") + system +
                             " marker is as given or assumed on the command line.";
    const std::vector<std::string> unknown = analyse(r).unknown;
    return std::count(unknown.begin(), unknown.end(), line);
  };
  EXPECT_EQ(told("ArUco"), 0) << "truth tells it";
  SequenceOptions options;
  options.aruco = Marker{"DICT_4X4_50", -1, 0.05};
  r.sequence = open_sequence(shipped("compare"), options);
  EXPECT_EQ(told("ArUco"), 1);
  EXPECT_EQ(told("AprilTag"), 0);
}

TEST(Report, FramesThatTruthDoesNotKnowAreNoted) {
  const TemporaryFolder folder;
  Recording r = compare_sequence().recording;
  r.sequence.truth->frames.resize(60);
  const auto notes = write_report(folder / "report", {"handyar evaluate", "0"}, {analyse(r)}, {});
  EXPECT_EQ(std::count(notes.begin(), notes.end(),
                       "compare: truth.json knows 60 of 90 frames; the others are not judged"),
            1);
  const ErrorColumns columns = error_columns(analyse(r));
  for (const char* flag : {"eligible", "no_open_hand", "on_other_hand", "wrong"}) {
    EXPECT_EQ((*columns.find(flag))[59], flag == std::string("eligible")) << flag;
    EXPECT_TRUE(std::isnan((*columns.find(flag))[60])) << flag << " is empty in errors.csv";
  }
}

TEST(Report, ThePapersBoardErrorsStandBesideBoardErrorsOnly) {
  Analysis a = compare_sequence();
  const auto paper_columns = [&a] {
    const Table t = table2(a);
    return std::count_if(t.figures.begin(), t.figures.end(),
                         [](const Figure& f) { return f.column == "paper full"; });
  };
  EXPECT_GT(paper_columns(), 0);
  for (auto& view : a.recording.board_views) view.reset();
  for (TrackAnalysis& track : a.tracks) track.raw.blocks_px.clear();
  EXPECT_EQ(paper_columns(), 0);
}

// The pose of one frame is off while its fingertips are right.
TEST(Pictures, AmongTheWorstFramesAreTheWorstPoses) {
  Analysis a = compare_sequence();
  std::vector<FrameError>& errors = a.tracks.front().errors;
  const std::size_t bad = errors.size() / 2;
  ASSERT_TRUE(errors[bad].counted());
  errors[bad].filtered.rotation_deg = 40;
  bool shown = false;
  for (const Picture& p : take_pictures(a)) shown |= p.worst && p.frame == int(bad);
  EXPECT_TRUE(shown);
}

}  // namespace
}  // namespace handyar::evaluation
