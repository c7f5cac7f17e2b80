// SPDX-License-Identifier: MIT
// `handyar track` as its users meet it.
#include <opencv2/core.hpp>
#include <set>
#include <sstream>

#include "command_line.hpp"
#include "handyar/io/frame_source.hpp"
#include "handyar/io/pose_csv.hpp"
#include "handyar/io/video_writer.hpp"

namespace handyar {
namespace {

TEST_F(CliTest, TracksAVideoAndSaysWhatItAssumed) {
  const Outcome r = run("track " + kVideo + outputs());
  EXPECT_EQ(r.code, 0) << r.err;
  EXPECT_EQ(lines(r.err), 2) << r.err;
  EXPECT_NE(r.err.find("60 degrees"), std::string::npos);
  EXPECT_NE(r.err.find("average adult hand"), std::string::npos);
  EXPECT_EQ(r.out.rfind("90 frames, ", 0), 0u) << r.out;
  EXPECT_EQ(left(), (std::set<std::string>{"p.csv", "v.mp4"}));
  const std::string poses = contents(out("p.csv"));
  EXPECT_EQ(poses.rfind(std::string(io::kPoseCsvHeader) + "\n0,0.000000,", 0), 0u);
  EXPECT_EQ(lines(poses), 91);
}

TEST_F(CliTest, AHandOfTheAverageSizeIsSaidToBe) {
  const std::string average = changed("hand.json", "\"truth\"", "\"default\"");
  const std::string err = run("track " + kVideo + " --hand " + average).err;
  EXPECT_NE(err.find(average + ": the average adult's size is assumed"), std::string::npos) << err;
}

TEST_F(CliTest, ACameraFileOfAnAssumedOneIsSaidToBe) {
  const std::string camera = changed("camera.yml", "image_width", "assumed: 1\nimage_width");
  const std::string err = run("track " + kVideo + " --camera " + camera).err;
  EXPECT_NE(err.find(camera + ": its field of view is assumed"), std::string::npos) << err;
}

TEST_F(CliTest, OfTwoHandsTheSecondIsLookedForBesideTheFirst) {
  const Outcome r =
      run("track " + kVideo + " --hands 2" + outputs() + " --events " + out("e.jsonl"));
  EXPECT_EQ(r.code, 0) << r.err;
  EXPECT_NE(r.out.find("tracked, 0.0 % with both hands"), std::string::npos) << r.out;
  std::istringstream poses(contents(out("p.csv")));
  std::string row;
  std::getline(poses, row);
  for (int i = 0; std::getline(poses, row); ++i) {
    EXPECT_EQ(row.rfind(std::to_string(i / 2) + ",", 0), 0u) << row;
    EXPECT_EQ(row.back(), i % 2 == 0 ? '1' : '2') << row;
    if (i % 2 == 1) {
      EXPECT_NE(row.find("searching"), std::string::npos) << row;
    }
  }
  EXPECT_EQ(lines(contents(out("p.csv"))), 181);
  const std::string events = contents(out("e.jsonl"));
  EXPECT_NE(events.find("\"hand\":1"), std::string::npos) << events;
  EXPECT_EQ(events.find("\"hand\":2"), std::string::npos) << events;
  EXPECT_EQ(run("track " + kVideo + " --hands 2 --method paper").code, 2);
}

TEST_F(CliTest, SameInputGivesTheSameRows) {
  const std::string files =
      " --camera " + kData + "/compare/camera.yml --hand " + kData + "/compare/hand.json";
  const Outcome a = run("track " + kVideo + files + " --no-timings --poses " + out("a.csv"));
  const Outcome b = run("track " + kVideo + files + " --no-timings --poses " + out("b.csv"));
  EXPECT_EQ(a.code, 0);
  EXPECT_EQ(a.err, "");
  EXPECT_EQ(a.out.find("median"), std::string::npos);
  EXPECT_NE(contents(out("a.csv")), "");
  EXPECT_EQ(contents(out("a.csv")), contents(out("b.csv")));
}

TEST_F(CliTest, VideoThatBreaksOffKeepsItsRows) {
  const std::string whole = contents(kVideo);
  write("half.mp4", whole.substr(0, whole.size() / 2));
  const Outcome r = run("track " + in("half.mp4") + outputs());
  EXPECT_EQ(r.code, 1);
  EXPECT_EQ(left(), (std::set<std::string>{"p.csv", "v.mp4"}));
  const int rows = lines(contents(out("p.csv"))) - 1;
  EXPECT_GT(rows, 20);
  EXPECT_LT(rows, 80);
  EXPECT_NE(
      r.err.find("half.mp4: breaks off: " + std::to_string(rows) + " of 90 frames could be read\n"),
      std::string::npos)
      << r.err;
}

TEST_F(CliTest, FileThatMayGrowNoMoreIsAFault) {
  const Outcome r = run("track " + kVideo + " --video " + out("v.mp4"),
                        "sh -c 'ulimit -f 8; exec \"$0\" \"$@\"'");
  EXPECT_EQ(r.code, 1);
  EXPECT_NE(r.err.find("v.mp4: cannot be written: File too large\n"), std::string::npos) << r.err;
  EXPECT_EQ(left(), (std::set<std::string>{}));
}

TEST_F(CliTest, WhatStandardOutputHoldsStays) {
  for (const char* file : {"--poses", "--events"}) {
    std::ofstream(out("all")) << "before\n";
    const std::string command = std::string("'" HANDYAR_PROGRAM "' track ") + kVideo + " " + file +
                                " /dev/stdout >>" + out("all") + " 2>/dev/null";
    EXPECT_EQ(std::system(command.c_str()), 0);
    const std::string all = contents(out("all"));
    EXPECT_EQ(all.rfind("before\n", 0), 0u) << all;
    EXPECT_GT(lines(all), 1);
    EXPECT_EQ(all.find(" tracked, median"), std::string::npos) << "the summary is elsewhere";
  }
}

TEST_F(CliTest, ClosedStandardStreamsAreNoneOfTheOutputs) {
  const std::string track = "'" HANDYAR_PROGRAM "' track " + kVideo + " --no-timings --poses ";
  EXPECT_EQ(std::system((track + out("closed.csv") + " <&- >&- 2>&-").c_str()), 0);
  EXPECT_EQ(run("track " + kVideo + " --no-timings --poses " + out("open.csv")).code, 0);
  EXPECT_EQ(contents(out("closed.csv")), contents(out("open.csv")));
}

TEST_F(CliTest, DebugWritesTheStagesOfTheChosenFrames) {
  const Outcome r = run("track " + kVideo + " --debug " + out("") + " --debug-frames 0,60-61");
  EXPECT_EQ(r.code, 0) << r.err;
  std::set<std::string> wanted;
  for (const char* frame : {"frame_000060_", "frame_000061_"})
    for (const char* stage : {"1_input.png", "3_outline.png", "4_region.png", "5_pose.png"})
      wanted.insert(std::string(frame) + stage);
  for (const std::string& name : wanted) EXPECT_TRUE(left().contains(name)) << name;
  EXPECT_TRUE(left().contains("frame_000000_2_candidates.png"));
  for (const std::string& name : left()) EXPECT_EQ(name.substr(name.size() - 4), ".png");

  const Outcome late = run("track " + kVideo + " --debug " + in("late") + " --debug-frames 88-90");
  EXPECT_EQ(late.code, 1);
  EXPECT_EQ(late.err.substr(late.err.rfind("handyar: ")),
            "handyar: " + kVideo + ": --debug-frames asks for frame 90, the last one is 89\n");
  write("file", "");
  fs::remove_all(root_ / "out");
  fs::create_directories(root_ / "out");
  expect_refused(kVideo + " --debug " + in("file"), in("file"), "cannot be made");
  expect_refused(kVideo + " --debug /proc/stages", "/proc/stages", "cannot be made");
  for (const char* frames : {"x", "5-", "7-3", "1,,2", "-1", "99999999999999999999"})
    EXPECT_EQ(run("track " + kVideo + " --debug " + in("d") + " --debug-frames " + frames).code, 2)
        << frames;
  EXPECT_EQ(run("track " + kVideo + " --debug-frames 3").code, 2);
}

TEST_F(CliTest, SaysWhatIsMissingWhenNothingWasTracked) {
  const auto film = [&](const cv::Matx34f& change, const cv::Rect& blob = {}) {
    const auto source = io::open_input(kVideo);
    io::VideoWriter writer(in("f.avi"), source->info().width_px, source->info().height_px, 30);
    for (io::Frame frame; source->read(frame);) {
      cv::transform(frame.bgr, frame.bgr, change);
      if (!blob.empty()) frame.bgr(blob) = cv::Scalar(110, 140, 200);
      writer.write(frame.bgr, frame.time_s);
    }
    writer.finish();
    const Outcome r = run("track " + in("f.avi"));
    EXPECT_EQ(r.code, 0) << r.err;
    EXPECT_EQ(lines(r.out), 2) << r.out;
    return r.out;
  };
  const std::string dark = film({0, 0, 0, 5, 0, 0, 0, 10, 0, 0, 0, 25});
  EXPECT_NE(dark.find("\nthe pictures are too dark"), std::string::npos) << dark;
  const std::string wall = film({0, 0, 0, 180, 0, 0, 0, 120, 0, 0, 0, 60});
  EXPECT_NE(wall.find("\nnothing of skin's colour was seen"), std::string::npos) << wall;
  const std::string grey = film({0, 0, 0, 120, 0, 0, 0, 120, 0, 0, 0, 120});
  EXPECT_NE(grey.find("\nthe pictures are grey"), std::string::npos) << grey;
  const std::string fist = film({0, 0, 0, 180, 0, 0, 0, 120, 0, 0, 0, 60}, {120, 80, 150, 160});
  EXPECT_NE(fist.find("\nskin was seen, but not five fingers"), std::string::npos) << fist;
  const std::string skin = film({0, 0, 0, 110, 0, 0, 0, 140, 0, 0, 0, 200});
  EXPECT_NE(skin.find("\nnearly all is of skin's colour"), std::string::npos) << skin;
  EXPECT_EQ(lines(run("track " + kVideo).out), 1);
}

TEST_F(CliTest, EventsTellWhenTheHandIsFoundAndLost) {
  const std::string track =
      "track " + kVideo + " --poses " + out("p.csv") + " --events " + out("e.jsonl");
  EXPECT_EQ(run(track).code, 0);
  const std::string events = contents(out("e.jsonl"));
  EXPECT_EQ(events.rfind("{\"event\":\"found\",\"frame\":", 0), 0u) << events;
  EXPECT_NE(events.find("\"layout\":\"thumb_"), std::string::npos) << events;
  int changes = 0;
  std::string before = "none", row;
  for (std::istringstream rows(contents(out("p.csv"))); std::getline(rows, row);) {
    const bool tracked = row.find(",tracking,") != std::string::npos;
    changes += tracked != (before == "tracking");
    before = tracked ? "tracking" : "none";
  }
  EXPECT_EQ(lines(events), changes);
  EXPECT_EQ(run("track " + kVideo + " --events " + out("a") + " --poses " + out("a")).code, 2);
}

TEST_F(CliTest, MirroredPicturesShowTheSamePosesTheOtherWayRound) {
  const auto track = [&](const std::string& name, const std::string& more) {
    const Outcome r = run("track " + kVideo + more + " --no-timings --poses " + out(name + ".csv") +
                          " --video " + out(name + ".avi"));
    EXPECT_EQ(r.code, 0) << r.err;
  };
  track("plain", " --no-annotation");
  track("mirrored", " --no-annotation --mirror");
  track("said", " --mirror");
  EXPECT_EQ(contents(out("plain.csv")), contents(out("mirrored.csv")));
  const auto plain = io::open_input(out("plain.avi")),
             mirrored = io::open_input(out("mirrored.avi"));
  io::Frame a, b;
  ASSERT_TRUE(plain->read(a) && mirrored->read(b));
  cv::Mat turned;
  cv::flip(b.bgr, turned, 1);
  EXPECT_LT(cv::norm(a.bgr, turned, cv::NORM_L1) / double(3 * a.bgr.total()), 3);
  EXPECT_GT(cv::norm(a.bgr, b.bgr, cv::NORM_L1) / double(3 * a.bgr.total()), 6);
}

}  // namespace
}  // namespace handyar
