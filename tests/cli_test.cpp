// SPDX-License-Identifier: MIT
// The command line as its users meet it: the built program is run, and its exit code, its words and
// the files it leaves are looked at.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <set>
#include <sstream>
#include <thread>

#include "handyar/io/frame_source.hpp"
#include "handyar/io/pose_csv.hpp"
#include "handyar/io/video_writer.hpp"
#include "temporary_folder.hpp"

namespace fs = std::filesystem;

namespace handyar {
namespace {

const std::string kData = HANDYAR_DATA_DIR;
const std::string kVideo = kData + "/compare/video.mp4";

struct Outcome {
  int code = -1;
  std::string out, err;
};

std::string contents(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

int lines(const std::string& text) {
  return static_cast<int>(std::count(text.begin(), text.end(), '\n'));
}

class CliTest : public testing::Test {
 protected:
  CliTest() {
    fs::create_directories(root_ / "out");
    fs::create_directories(root_ / "in");
  }

  std::string in(const std::string& name) const { return (root_ / "in" / name).string(); }
  std::string out(const std::string& name) const { return (root_ / "out" / name).string(); }
  std::string outputs() const { return " --poses " + out("p.csv") + " --video " + out("v.mp4"); }
  std::set<std::string> left() const {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(root_ / "out")) {
      names.insert(entry.path().filename().string());
    }
    return names;
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(in(name), std::ios::binary) << text;
  }
  // A file of the sample with one thing changed.
  std::string changed(const std::string& file, const std::string& what,
                      const std::string& by) const {
    std::string text = contents(kData + "/compare/" + file);
    const auto at = text.find(what);
    EXPECT_NE(at, std::string::npos);
    write(file, text.replace(at, what.size(), by));
    return in(file);
  }

  Outcome run(const std::string& arguments, const std::string& environment = "") const {
    const std::string out = (root_ / "stdout").string(), err = (root_ / "stderr").string();
    const std::string config = "XDG_CONFIG_HOME='" + (root_ / "config").string() + "' ";
    const int status = std::system((config + environment + " '" HANDYAR_PROGRAM "' " + arguments +
                                    " >" + out + " 2>" + err + " </dev/null")
                                       .c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), contents(out),
            contents(err)};
  }

  // Exit 1, one line that names `subject`, and nothing left behind.
  void expect_refused(const std::string& arguments, const std::string& subject,
                      const std::string& fault, const std::string& command = "track ") const {
    const Outcome r = run(command + arguments);
    EXPECT_EQ(r.code, 1) << arguments;
    EXPECT_EQ(lines(r.err), 1) << r.err;
    EXPECT_EQ(r.err.rfind("handyar: " + subject + ": ", 0), 0u) << r.err;
    EXPECT_NE(r.err.find(fault), std::string::npos) << r.err;
    EXPECT_EQ(r.out, "");
    EXPECT_EQ(left(), std::set<std::string>{}) << arguments;
  }

  const test::TemporaryFolder temporary_;
  const fs::path& root_ = temporary_.path();
};

TEST_F(CliTest, BadInputsAreRefusedInOneLine) {
  write("text.mp4", "This is a text.\n");
  write("one.pgm.ppm", std::string("P6\n1 1\n255\nabc"));
  expect_refused(in("text.mp4") + outputs(), in("text.mp4"), "is a text file, not a video");
  expect_refused(in("no.mp4") + outputs(), in("no.mp4"), "no such file");
  expect_refused(in("") + outputs(), in(""), "is a folder");
  expect_refused(in("one.pgm.ppm") + outputs(), in("one.pgm.ppm"), "1x1");
  expect_refused("/dev/video987" + outputs(), "/dev/video987", "no such camera");
}

TEST_F(CliTest, BadFilesAreRefusedInOneLine) {
  const std::string nan = changed("camera.yml", "data: [ 6", "data: [ .nan, 6");
  expect_refused(kVideo + " --camera " + nan + outputs(), nan, "camera_matrix");
  const std::string wide = changed("camera.yml", "image_width: 640", "image_width: 853");
  expect_refused(kVideo + " --camera " + wide + outputs(), wide, "another shape");
  const std::string four = changed("hand.json", "\"little\"", "\"fifth\"");
  expect_refused(kVideo + " --hand " + four + outputs(), four, "there is no fifth on a hand");
  expect_refused(kVideo + " --hand " + in("no.json") + outputs(), in("no.json"), "cannot be read");
  expect_refused(kVideo + " --camera " + in("no.yml") + outputs(), in("no.yml"), "cannot be read");
}

TEST_F(CliTest, OutputsThatCannotBeWrittenAreRefusedInOneLine) {
  expect_refused(kVideo + " --poses /proc/p.csv", "/proc/p.csv", "cannot be written");
  expect_refused(kVideo + " --video /proc/v.mp4 --poses " + out("p.csv"), "/proc/v.mp4",
                 "cannot be written");
  expect_refused(kVideo + " --poses " + out("no/p.csv"), out("no/p.csv"), "cannot be written");
  const Outcome r = run("demo --out /proc/demo");
  EXPECT_EQ(r.code, 1);
  EXPECT_EQ(lines(r.err), 1) << r.err;
}

TEST_F(CliTest, NoDisplayIsSaidInOneLine) {
  for (const char* display : {"-u DISPLAY", "DISPLAY=:987"}) {
    const Outcome r =
        run("track " + kVideo + " --show", std::string("env -u WAYLAND_DISPLAY ") + display);
    EXPECT_EQ(r.code, 1);
    EXPECT_EQ(lines(r.err), 1) << r.err;
    EXPECT_EQ(r.err.rfind("handyar: --show: ", 0), 0u) << r.err;
  }
}

TEST_F(CliTest, WrongUsageIsTwo) {
  fs::copy_file(kVideo, in("v.mp4"));
  for (const std::string& arguments :
       {std::string(""),
        std::string("dance"),
        std::string("track"),
        "track " + kVideo + " --poses",
        "track " + kVideo + " --processing third",
        "track " + kVideo + " --fingertips nails",
        "track " + kVideo + " --poses " + out("a") + " --video " + out("a"),
        "track " + in("v.mp4") + " --video " + in("v.mp4"),
        "track " + in("%04d.mp4") + " --poses " + in("../in/0003.mp4"),
        "track " + kVideo + " --video " + out("v.webm"),
        "track " + kVideo + " --record " + out("v.avi"),
        "track " + kVideo + " --attach index_tip",
        "track " + kVideo + " --processing half",
        "evaluate " + kVideo + " --square-mm 20 --report " + out("r"),
        std::string("setup --show"),
        "track " + kVideo + " another",
        "track " + kVideo + " --model " + in("v.mp4") + " --poses " + in("v.mp4"),
        "track " + kVideo + " --poses ''",
        "track " + kVideo + " --model teapot --model-mm nan",
        std::string("dance --help"),
        std::string("--dance"),
        std::string("cameras 1"),
        "learn-color " + in("v.mp4") + " --out " + in("./v.mp4"),
        "world " + in("v.mp4") + " --map " + in("v.mp4"),
        "world " + kVideo + " --model-mm 0",
        "inspect " + in("v.mp4") + " --scene " + kData + "/scene_select.json --events " +
            in("../in/v.mp4"),
        "calibrate " + in("v.mp4") + " --board 8x6 --square-mm 22 --camera-out " + out("a") +
            " --hand-out " + out("./a"),
        "board --square-mm nan --out " + out("b.pdf")}) {
    const Outcome r = run(arguments);
    EXPECT_EQ(r.code, 2) << arguments;
    EXPECT_EQ(lines(r.err), 1) << r.err;
    EXPECT_EQ(left(), std::set<std::string>{});
  }
  EXPECT_EQ(contents(in("v.mp4")), contents(kVideo));
}

TEST_F(CliTest, HelpVersionAndCamerasSucceed) {
  EXPECT_EQ(run("--version").out.rfind("handyar ", 0), 0u);
  for (const char* arguments : {"--help", "track --help", "demo --help", "cameras --help"}) {
    const Outcome r = run(arguments);
    EXPECT_EQ(r.code, 0) << arguments;
    EXPECT_EQ(r.err, "");
    EXPECT_NE(r.out.find("Usage: handyar"), std::string::npos) << r.out;
  }
  const std::string help = run("track --help").out;
  for (const char* line : {"--model-mm 1 to 10000", "--processing full|half (full)"})
    EXPECT_NE(help.find(line), std::string::npos) << help;
  EXPECT_EQ(help.find("FLOAT"), std::string::npos) << "no word of people's";
  const Outcome far = run("track " + kVideo + " --model-mm 0");
  EXPECT_EQ(far.code, 2);
  EXPECT_NE(far.err.find("0 is not a number from 1 to 10000"), std::string::npos) << far.err;
  const Outcome cameras = run("cameras");
  EXPECT_EQ(cameras.code, 0);
  EXPECT_GE(lines(cameras.out), 1);
}

TEST_F(CliTest, BashCompletesOptionsAndTheirChoices) {
  const auto completed = [&](const std::string& words) {
    const std::string script = ". '" + kData + "/../apps/handyar/completion.bash'\n" +
                               "COMP_WORDS=('" HANDYAR_PROGRAM "' " + words +
                               ") COMP_CWORD=$((${#COMP_WORDS[@]} - 1))\n"
                               "_handyar\necho \"${COMPREPLY[@]}\"\n";
    write("script", script);
    EXPECT_EQ(std::system(("bash " + in("script") + " >" + out("said") + " 2>&1").c_str()), 0);
    return contents(out("said"));
  };
  EXPECT_EQ(completed("calibrate --h"), "--help --hand-out --hand-length-mm\n");
  EXPECT_EQ(completed("calibrate --s"), "--square-mm --self --span-mm --show\n");
  EXPECT_EQ(completed("track --attach index_"), "index_base index_tip\n");
  EXPECT_EQ(completed("track a/b.mp4 ''"), "\n");
}

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

TEST_F(CliTest, InterruptFinishesTheFiles) {
  const pid_t child = ::fork();
  if (child == 0) {
    std::freopen("/dev/null", "w", stderr);
    ::execl(HANDYAR_PROGRAM, "handyar", "track", (kData + "/sample/video.mp4").c_str(), "--poses",
            out("p.csv").c_str(), "--video", out("v.mp4").c_str(), nullptr);
    ::_exit(99);
  }
  // Interrupts are caught before the first output file is there.
  while (left().empty()) std::this_thread::yield();
  ::kill(child, SIGINT);
  int status = 0;
  ::waitpid(child, &status, 0);
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return;  // it was done before the signal came
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  EXPECT_EQ(left(), (std::set<std::string>{"p.csv", "v.mp4"}));
  const std::string poses = contents(out("p.csv"));
  EXPECT_EQ(poses.back(), '\n');
  EXPECT_LT(lines(poses), 201);
}

TEST_F(CliTest, OneInterruptEndsTheWaitForThePipesReader) {
  ASSERT_EQ(::mkfifo(out("p.csv").c_str(), 0600), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    std::freopen("/dev/null", "w", stderr);
    ::execl(HANDYAR_PROGRAM, "handyar", "track", kVideo.c_str(), "--poses", out("p.csv").c_str(),
            nullptr);
    ::_exit(99);
  }
  std::this_thread::sleep_for(std::chrono::seconds(1));
  ::kill(child, SIGTERM);
  int status = 0;
  for (int i = 0; ::waitpid(child, &status, WNOHANG) == 0; ++i) {
    if (i == 100) ::kill(child, SIGKILL);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 1);
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

TEST_F(CliTest, StandardOutputThatIsFullIsAFault) {
  for (const char* arguments : {"cameras", "--version", "track --help", "setup"}) {
    const std::string command = std::string("'" HANDYAR_PROGRAM "' ") + arguments;
    const int status = std::system((command + " >/dev/full 2>" + out("err")).c_str());
    EXPECT_EQ(WEXITSTATUS(status), 1) << arguments;
    EXPECT_EQ(contents(out("err")), "handyar: standard output: cannot be written\n");
  }
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

// The hand of this clip lies still beside a board, and the camera begins to move.
const std::string kWorldClip =
    kVideo + " --camera " + kData + "/compare/camera.yml --hand " + kData + "/compare/hand.json";

TEST_F(CliTest, AWorldIsWrittenAndFoundAgain) {
  const std::string files = " --scene " + out("desk.json") + " --poses " + out("p.csv");
  const Outcome first = run("world " + kWorldClip + files + " --events " + out("e.jsonl"));
  EXPECT_EQ(first.code, 0) << first.err;
  EXPECT_EQ(first.err, "");
  EXPECT_EQ(left(), (std::set<std::string>{"desk.json", "desk.map", "e.jsonl", "p.csv"}));
  EXPECT_EQ(contents(out("e.jsonl")), "{\"event\":\"world_found\",\"frame\":15,\"time_s\":0.5}\n");
  const std::string rows = contents(out("p.csv")), scene = contents(out("desk.json"));
  EXPECT_EQ(lines(rows), 91);
  EXPECT_NE(rows.find("\n14,0.466667,setting,,"), std::string::npos) << rows;
  EXPECT_NE(rows.find("\n15,0.500000,tracked,0."), std::string::npos) << rows;
  EXPECT_NE(scene.find("\"map\": \"desk.map\""), std::string::npos) << scene;

  const Outcome second = run("world " + kWorldClip + files);
  EXPECT_EQ(second.code, 0) << second.err;
  EXPECT_NE(contents(out("p.csv")).find("\n3,0.100000,tracked,0."), std::string::npos);
  EXPECT_EQ(lines(contents(out("desk.json"))), lines(scene));  // the same object
}

TEST_F(CliTest, BadWorldsAreRefusedInOneLine) {
  const auto refused = [&](const std::string& arguments, const std::string& subject,
                           const std::string& fault) {
    expect_refused(
        kWorldClip + " --poses " + out("p.csv") + " --events " + out("e.jsonl") + arguments,
        subject, fault, "world ");
  };
  write("broken.map", "{\"format\": \"handyar-map\", \"version\": 1}\n");
  write("text.map", "This is a text.\n");
  refused(" --map " + in("broken.map"), in("broken.map"), "camera");
  refused(" --map " + in("text.map"), in("text.map"), "is not a map");
  refused(" --map /proc/desk.map", "/proc/desk.map", "cannot be written");
  refused(" --model " + in("no.obj") + " --video " + out("v.mp4"), in("no.obj"), "no such model");
  refused(" --scene " + kData + "/scene_select.json", kData + "/scene_select.json", "of markers");
  write("desk.json",
        R"({"format": "handyar-scene", "version": 1, "world": {"map": "gone.map"},
            "objects": [{"model": "teapot"}]})");
  refused(" --scene " + in("desk.json"), in("desk.json"), "gone.map is not there");
}

TEST_F(CliTest, AWorldThatNobodySetLeavesNoMap) {
  const Outcome r =
      run("world " + kData + "/wall/video.mp4 --map " + out("a.map") + " --scene " + out("a.json"));
  EXPECT_EQ(r.code, 0) << r.err;
  EXPECT_EQ(r.out.rfind("no world: too little to see around the hand (in ", 0), 0u) << r.out;
  EXPECT_EQ(left(), std::set<std::string>{});
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

TEST_F(CliTest, SetupRemembersTheHandForWhenNoneIsGiven) {
  EXPECT_EQ(run("setup").out, "camera       none\ncalibration  none\nhand         none\n");
  const std::string files =
      " --camera " + kData + "/compare/camera.yml --hand " + kData + "/compare/hand.json";
  const Outcome set = run("setup" + files);
  EXPECT_EQ(set.code, 0) << set.err;
  const std::string hand = (root_ / "config/handyar/hand.json").string();
  EXPECT_NE(set.out.find("hand         " + hand), std::string::npos) << set.out;

  const Outcome r = run("track " + kVideo + " --no-timings --poses " + out("remembered.csv"));
  EXPECT_EQ(r.code, 0);
  EXPECT_NE(r.err.find("no --hand: " + hand + " is taken"), std::string::npos) << r.err;
  EXPECT_NE(r.err.find("60 degrees"), std::string::npos) << "the camera is not that of a file";
  run("track " + kVideo + " --no-timings --hand " + kData + "/compare/hand.json --poses " +
      out("given.csv"));
  EXPECT_EQ(contents(out("remembered.csv")), contents(out("given.csv")));
  EXPECT_EQ(run("track " + kVideo + " --hand average").err.find("--hand"), std::string::npos);

  // A recording need not be of the remembered camera.
  EXPECT_EQ(
      run("setup --camera " + changed("camera.yml", "image_width: 640", "image_width: 853")).code,
      0);
  const std::string measured = run("setup " + kVideo + " --span-mm 190").err;
  EXPECT_EQ(measured.find("another shape"), std::string::npos) << measured;
  EXPECT_NE(measured.find("60 degrees is assumed"), std::string::npos) << measured;
  const std::string nowhere =
      run("setup " + kVideo + " --span-mm 190", "XDG_CONFIG_HOME=/proc").err;
  EXPECT_EQ(nowhere.rfind("handyar: /proc/handyar: ", 0), 0u) << nowhere;
  EXPECT_EQ(run("setup --hand " + in("no.json")).code, 1);
  EXPECT_EQ(run("setup " + kVideo).code, 2) << "a file is no camera";
  EXPECT_EQ(run("setup --forget").out, "camera       none\ncalibration  none\nhand         none\n");
  EXPECT_FALSE(fs::exists(root_ / "config/handyar"));
}

TEST_F(CliTest, CameraSettingsAreForCameras) {
  for (const char* option : {" --camera-size 1280x720", " --camera-fps 60", " --camera-lock"}) {
    const Outcome r = run("track " + kVideo + option);
    EXPECT_EQ(r.code, 1) << option;
    EXPECT_EQ(lines(r.err), 1) << r.err;
    EXPECT_NE(r.err.find("is no camera"), std::string::npos) << r.err;
  }
  for (const char* size : {"1280", "1280x", "x720", "1280x720p", "-1x2"})
    EXPECT_EQ(run("track " + kVideo + " --camera-size " + size).code, 2) << size;
}

TEST_F(CliTest, DemoMakesVideoAndPoses) {
  const Outcome r = run("demo --out " + out("demo"));
  EXPECT_EQ(r.code, 0) << r.err;
  EXPECT_EQ(r.err, "");
  EXPECT_NE(r.out.find("200 frames"), std::string::npos) << r.out;
  EXPECT_EQ(lines(contents(out("demo/poses.csv"))), 201);
  EXPECT_GT(fs::file_size(out("demo/annotated.mp4")), 100000u);
}

}  // namespace
}  // namespace handyar
