// SPDX-License-Identifier: MIT
// What the evaluation is given: photographs, truth, sequences and trees of footage, and what is
// said of those that cannot be judged.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "evaluation_files.hpp"
#include "handyar/evaluation/footage.hpp"
#include "handyar/evaluation/report.hpp"
#include "handyar/io/error.hpp"
#include "handyar/io/frame_source.hpp"

namespace handyar::evaluation {
namespace {

/// What is said against a list of one photograph with these tips, the picture being this file.
std::string complaint_about_stills(const TemporaryFolder& folder, const std::string& row,
                                   const std::string& picture) {
  std::ofstream(folder / "a.ppm", std::ios::binary) << picture;
  std::ofstream(folder / "list.csv") << "\xEF\xBB\xBF"  // as spreadsheets begin a file
                                        "file,thumb_x,thumb_y,index_x,index_y,middle_x,middle_y,"
                                        "ring_x,ring_y,little_x,little_y\n\n"
                                     << row << "\n";
  try {
    track_stills(read_stills(folder / "list.csv"));
  } catch (const io::Error& e) {
    return e.what();
  }
  return "";
}

TEST(Stills, WhatCannotBeJudgedIsRefusedInOneLine) {
  const TemporaryFolder folder;
  const std::string tips = "50,30,20,40,10,50,20,60,40";
  const std::string picture = "P6\n64 48\n255\n" + std::string(64 * 48 * 3, '\0');
  const auto complaint = [&](const std::string& row, const std::string& content) {
    return complaint_about_stills(folder, row, content);
  };
  EXPECT_EQ(complaint("a.ppm,10," + tips, picture), "");
  for (const char* number : {"", "1e999", "1e308", "nan", "10 px"})
    EXPECT_EQ(complaint("a.ppm," + std::string(number) + "," + tips, picture),
              folder / "list.csv" + ": line 3: thumb_x is not a pixel: \"" + number + "\"");
  EXPECT_NE(complaint("a.ppm,60,40,20,40,10,50,20,60,60,40", picture).find("line 3: thumb and"),
            std::string::npos);
  EXPECT_NE(complaint("b.ppm,10," + tips, picture).find("b.ppm: there is no such picture"),
            std::string::npos);
  EXPECT_EQ(complaint("a.ppm,10," + tips, ""),
            folder / "a.ppm" + ": is not a picture that can be read");
  EXPECT_EQ(complaint("a.ppm,10," + tips, "P6\n5000 1\n255\n" + std::string(15000, '\0')),
            folder / "a.ppm" + ": 5000x1 pixels: too narrow");
}

TEST(Stills, AreJudgedByTheSpan) {
  const TemporaryFolder folder;
  std::ofstream(folder / "list.csv") << "file,thumb_x\n";
  EXPECT_THROW(read_stills(folder / "list.csv"), io::Error) << "no pictures";
  EXPECT_THROW(read_stills(folder / "missing.csv"), io::Error);
  std::vector<StillResult> results;
  for (const auto outcome : {StillResult::Outcome::right, StillResult::Outcome::right,
                             StillResult::Outcome::wrong, StillResult::Outcome::not_found}) {
    StillResult r{outcome, "a_1.jpg", "a", "", kUnknown, {}};
    if (outcome == StillResult::Outcome::right) r.of_span = {0.01, 0.02, 0.03, 0.04, 0.05};
    results.push_back(r);
  }
  const Table t = stills_table(results);
  EXPECT_DOUBLE_EQ(value_of(t, "all", "right, share"), 50);
  EXPECT_DOUBLE_EQ(value_of(t, "a", "wrong"), 1);
  EXPECT_DOUBLE_EQ(value_of(t, "all", "error of span, median"), 0.03);
}

// Enlarged fourfold the centre of a small picture's first pixel lies at (1.5, 1.5).
TEST(Stills, FingertipsOfASmallPictureAreWhereItsPixelsGo) {
  const TemporaryFolder folder;
  constexpr int kSmaller = 4;
  const Sequence s = open_sequence(shipped("compare"), {});
  std::ofstream list(folder / "list.csv");
  list << "file,thumb_x,thumb_y,index_x,index_y,middle_x,middle_y,ring_x,ring_y,little_x,"
          "little_y\n";
  io::Frame frame;
  for (const auto source = io::open_input(s.video); source->read(frame);) {
    if (frame.index % 15 != 0) continue;
    const std::string name = std::to_string(frame.index) + ".png";
    cv::Mat small;
    cv::resize(frame.bgr, small, {}, 1.0 / kSmaller, 1.0 / kSmaller, cv::INTER_AREA);
    cv::imwrite(folder / name, small);
    list << name;
    for (const Eigen::Vector2d& tip : s.truth->frames[std::size_t(frame.index)].tips_px)
      list << "," << (tip.x() + 0.5) / kSmaller - 0.5 << "," << (tip.y() + 0.5) / kSmaller - 0.5;
    list << "\n";
  }
  list.close();
  const Table t = stills_table(track_stills(read_stills(folder / "list.csv")));
  EXPECT_EQ(value_of(t, "all", "right"), 6);
  EXPECT_LT(value_of(t, "all", "error of span, median"), 0.0095);
}

TEST(Truth, AFileThatIsNoneIsRefusedInOneLine) {
  const TemporaryFolder folder;
  for (const char* text : {"", "{", "{\"K\": 1}", "[]"}) {
    std::ofstream(folder / "truth.json") << text;
    try {
      read_truth(folder / "truth.json");
      ADD_FAILURE() << text;
    } catch (const io::Error& e) {
      EXPECT_NE(std::string(e.what()).find("truth.json"), std::string::npos);
      EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
    }
  }
}

TEST(Truth, WhatCannotBeMeasuredAgainstIsRefused) {
  const TemporaryFolder folder;
  using nlohmann::json;
  const json shipped_truth = json::parse(text_of(shipped("compare") + "/truth.json"));
  const auto complaint = [&](auto change) -> std::string {
    json truth = shipped_truth;
    change(truth);
    std::ofstream(folder / "truth.json") << truth;
    try {
      read_truth(folder / "truth.json");
    } catch (const io::Error& e) {
      return e.what();
    }
    return "";
  };
  const auto has = [](const std::string& text, const char* part) {
    return text.find(part) != std::string::npos;
  };
  EXPECT_TRUE(has(complaint([](json& j) { j["frames"] = json::array(); }), "no frames"));
  EXPECT_TRUE(has(complaint([](json& j) { j["frames"] = nullptr; }), "no frames"));
  EXPECT_TRUE(has(complaint([](json& j) { j["K"][0][0] = 0; }), "focal length"));
  EXPECT_TRUE(has(complaint([](json& j) { j["width"] = 0; }), "no size"));
  EXPECT_TRUE(has(complaint([](json& j) { j["fps"] = 0; }), "fps"));
  EXPECT_TRUE(has(complaint([](json& j) { j["dist"] = {0, 0, 0, 0, 0, 0.1, 0, 0}; }), "dist"));
  EXPECT_EQ(complaint([](json& j) { j["dist"] = {0.1, 0, 0, 0, 0, 0, 0, 0}; }), "");
  EXPECT_TRUE(has(complaint([](json& j) { j["board"]["inner_corners"] = {1, 6}; }), "1x6"));
  EXPECT_TRUE(has(complaint([](json& j) { j["markers"][0]["dict"] = "DICT_9X9"; }), "DICT_9X9"));
  EXPECT_TRUE(has(complaint([](json& j) { j["markers"][0]["size_mm"] = 0; }), "size"));
  EXPECT_EQ(complaint([](json& j) { j["markers"][0]["dict"] = "DICT_4X4_1000"; }), "");
  EXPECT_FALSE(has(complaint([](json& j) { j.erase("K"); }), "json.exception"));
}

TEST(Sequences, OnlyAFolderHasItsOwnCameraAndHand) {
  const TemporaryFolder folder;
  fs::copy(fs::path(io::data_file("calibrate/video.mp4")).parent_path(), folder / "mine");
  EXPECT_EQ(open_sequence(folder / "mine", {}).origin_of_hand, folder / "mine/hand.json");
  const fs::path before = fs::current_path();
  fs::current_path(folder / "mine");  // where `handyar calibrate` writes what its help suggests
  const Sequence s = open_sequence("video.mp4", {});
  fs::current_path(before);
  EXPECT_EQ(s.origin_of_hand, "assumed: average adult");
  EXPECT_EQ(s.origin_of_camera, "assumed: 60 degrees across");
  EXPECT_EQ(s.name, "mine") << "every sequence's file is called video";
  cv::imwrite(folder / "mine/0001.png", cv::Mat(480, 640, CV_8UC3, cv::Scalar(90, 90, 90)));
  EXPECT_EQ(open_sequence(folder / "mine/%04d.png", {}).name, "mine");
}

TEST(Sequences, TruthOfAnotherSizeIsRefusedWhateverTheCamera) {
  const TemporaryFolder folder;
  fs::copy(shipped("compare"), folder / "mine");
  nlohmann::json truth = nlohmann::json::parse(text_of(folder / "mine/truth.json"));
  truth["width"] = 1280;
  truth["height"] = 960;
  std::ofstream(folder / "mine/truth.json") << truth;
  EXPECT_THROW(open_sequence(folder / "mine", {}), io::Error);
  SequenceOptions options;
  options.camera_file = folder / "mine/camera.yml";
  EXPECT_THROW(open_sequence(folder / "mine", options), io::Error);
}

TEST(Footage, TreeIsJudgedSequenceBySequence) {
  const TemporaryFolder folder;
  const fs::path tree = folder / "tree";
  fs::create_directories(tree / "rooms");
  fs::copy(shipped("compare"), tree / "rooms" / "board");
  fs::create_directories(tree / "clips");
  fs::copy(io::data_file("wall/video.mp4"), tree / "clips" / "wall.mp4");
  std::ofstream(tree / "clips" / "open_frames.csv")
      << "clip,frame,open,thumb_x,thumb_y,index_x,index_y,middle_x,middle_y,ring_x,ring_y,"
         "little_x,little_y\nwall.mp4,0,0,,,,,,,,,,\n";

  std::vector<FootageFigures> figures;
  for (const Footage& f : find_footage(tree, {})) figures.push_back(measure(f));
  ASSERT_EQ(figures.size(), 2u);
  EXPECT_EQ(figures[0].name, "wall");
  EXPECT_EQ(figures[0].open_frames, 0);
  EXPECT_EQ(figures[0].handless_frames, figures[0].frames) << "no frame of the list is open";
  EXPECT_GT(figures[0].falsely_tracked, 0) << "the clip does show a hand";
  EXPECT_EQ(figures[1].group, "rooms");
  EXPECT_GT(figures[1].open_frames, 20);
  EXPECT_GE(figures[1].right_percent(), 98.0);
  EXPECT_EQ(figures[1].wrong, 0);
  EXPECT_LE(figures[1].right_as_sound, figures[1].right);
  EXPECT_GE(figures[1].right_as_sound, 0.95 * figures[1].right);
  EXPECT_LE(figures[1].shown_changes, 1);
  EXPECT_EQ(figures[1].jumps, 0);
  EXPECT_EQ(figures[1].unsound, 0);

  const FootageFigures twice = measure(find_footage(tree / "clips", {})[0], 2);
  EXPECT_NEAR(twice.frames, 1.7 * figures[0].frames, 1) << "once whole, once from three tenths on";
  EXPECT_GT(twice.falsely_tracked, figures[0].falsely_tracked);

  fs::create_directories(folder / "report");
  const std::string text = write_distribution(folder / "report", figures);
  EXPECT_NE(text.find("## rooms"), std::string::npos);
  EXPECT_NE(text.find("rooms/board"), std::string::npos);
  EXPECT_EQ(lines_of(folder / "report/sequences.csv").size(), 3u);
  EXPECT_TRUE(fs::exists(folder / "report/worst-1.jpg"));
}

TEST(Footage, WhatIsNotKnownToBeHandlessIsNotSaidToBe) {
  const TemporaryFolder folder;
  const fs::path tree = folder / "tree";
  fs::create_directories(tree / "own");
  fs::copy(io::data_file("wall/video.mp4"), tree / "own" / "video.mp4");
  fs::copy(io::data_file("wall/video.mp4"), tree / "glimpse.mp4");
  std::ofstream list(tree / "open_frames.csv");
  list << "clip,frame,open,thumb_x,thumb_y,index_x,index_y,middle_x,middle_y,ring_x,ring_y,"
          "little_x,little_y\n";
  for (int frame = 40; frame < 46; ++frame)
    list << "glimpse.mp4," << frame << ",1,10,50,30,20,40,10,50,20,60,40\n";
  list.close();

  std::vector<FootageFigures> figures;
  for (const Footage& f : find_footage(tree, {})) figures.push_back(measure(f));
  ASSERT_EQ(figures.size(), 2u);
  EXPECT_EQ(figures[0].name, "glimpse");
  EXPECT_EQ(figures[0].open_frames, 0) << "none has been in view for long";
  EXPECT_EQ(figures[0].handless_frames, figures[0].frames - 6);
  EXPECT_EQ(figures[1].name, "own");
  EXPECT_GT(figures[1].frames, 100);
  EXPECT_EQ(figures[1].handless_frames, 0);
  EXPECT_EQ(figures[1].falsely_tracked, 0);

  fs::create_directories(folder / "report");
  const std::string text = write_distribution(folder / "report", figures);
  EXPECT_NE(text.find("tree/own: nothing is known of it."), std::string::npos) << text;
  EXPECT_NE(text.find("glimpse: " + std::to_string(figures[0].falsely_tracked) + " of "),
            std::string::npos)
      << text;
  EXPECT_EQ(text.find("far off"), std::string::npos) << "no truth tells";
}

TEST(Footage, AListThatCanBeReadInTwoWaysIsRefused) {
  const TemporaryFolder folder;
  const fs::path tree = folder / "tree";
  fs::create_directories(tree);
  fs::copy(io::data_file("wall/video.mp4"), tree / "a.mp4");
  const auto complaint = [&](const std::string& rows) -> std::string {
    std::ofstream(tree / "open_frames.csv")
        << "clip,frame,open,thumb_x,thumb_y,index_x,index_y,middle_x,middle_y,ring_x,ring_y,"
           "little_x,little_y\n"
        << rows;
    try {
      find_footage(tree, {});
    } catch (const io::Error& e) {
      return e.what();
    }
    return "";
  };
  const std::string tips = ",10,50,30,20,40,10,50,20,60,40\n", none = ",,,,,,,,,,\n";
  const std::string list = (tree / "open_frames.csv").string();
  EXPECT_EQ(complaint("a.mp4,7,1" + tips + "a.mp4,8,0" + none), "");
  for (const char* open : {"", "1.0", "True", "yes"})
    EXPECT_EQ(complaint("a.mp4,7," + std::string(open) + tips),
              list + ": line 2: open is neither 0 nor 1: \"" + open + "\"");
  for (const char* frame : {"", "-1", "7.5", "1e10", "seven"})
    EXPECT_EQ(complaint("a.mp4," + std::string(frame) + ",0" + none),
              list + ": line 2: frame is not a frame's number: \"" + frame + "\"");
  EXPECT_EQ(complaint("a.mp4,7,1" + tips + "a.mp4,7,0" + none),
            list + ": line 3: frame 7 of a.mp4 was there before");
}

TEST(Footage, EmptyTreeAndMissingClipAreRefusedByName) {
  const TemporaryFolder folder;
  const fs::path tree = folder / "tree";
  fs::create_directories(tree);
  EXPECT_THROW(find_footage(tree, {}), io::Error);
  std::ofstream(tree / "open_frames.csv")
      << "clip,frame,open,thumb_x,thumb_y,index_x,index_y,middle_x,middle_y,ring_x,ring_y,"
         "little_x,little_y\ngone.mp4,0,0,,,,,,,,,,\n";
  try {
    find_footage(tree, {});
    FAIL() << "gone.mp4 is not there";
  } catch (const io::Error& e) {
    EXPECT_NE(std::string(e.what()).find("gone.mp4"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace handyar::evaluation
