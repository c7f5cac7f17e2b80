// SPDX-License-Identifier: MIT
// `handyar evaluate` as its users meet it when something is wrong: one line, and nothing left.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "temporary_folder.hpp"

namespace fs = std::filesystem;

namespace handyar {
namespace {

const std::string kVideo = std::string(HANDYAR_DATA_DIR) + "/compare/video.mp4";
const std::string kHeader =
    "file,thumb_x,thumb_y,index_x,index_y,middle_x,middle_y,ring_x,ring_y,little_x,little_y\n";
const std::string kTips = "10,50,30,20,40,10,50,20,60,40";

class EvaluateCli : public testing::Test {
 protected:
  std::string file(const std::string& name) const { return (root_ / name).string(); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(file(name), std::ios::binary) << text;
    return file(name);
  }
  static std::string contents(const std::string& path) {
    std::ostringstream text;
    text << std::ifstream(path, std::ios::binary).rdbuf();
    return text.str();
  }

  int run(const std::string& arguments) const {
    const int status = std::system(("'" HANDYAR_PROGRAM "' evaluate " + arguments + " >" +
                                    file("stdout") + " 2>" + file("stderr") + " </dev/null")
                                       .c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  /// A line on standard error that tells `fault`, and no report.
  void expect_refused(const std::string& arguments, int code, const std::string& fault) const {
    const int exit_code = run(arguments);
    const std::string err = contents(file("stderr"));
    EXPECT_EQ(exit_code, code) << err;
    EXPECT_EQ(std::count(err.begin(), err.end(), '\n'), 1) << err;
    EXPECT_NE(err.find(fault), std::string::npos) << err;
    EXPECT_FALSE(fs::exists(file("report")));
  }

  const test::TemporaryFolder temporary_;
  const fs::path& root_ = temporary_.path();
};

TEST_F(EvaluateCli, AFaultyInputLeavesNoReport) {
  const std::string report = " --report " + file("report");
  expect_refused(file("no.mp4") + report, 1, "no.mp4: no such file");
  expect_refused("--stills " + file("no.csv") + report, 1, "no.csv: cannot be read");
  expect_refused("--stills " + write("empty.csv", "") + report, 1, "empty.csv: names no picture");
  write("broken.png", "\x89PNG\r\n\x1a\n and no more");
  const std::string list = write("list.csv", kHeader + "broken.png," + kTips + "\n");
  expect_refused("--stills " + list + report, 1, "broken.png: is not a picture");
}

TEST_F(EvaluateCli, TheReportsCommandCanBeRunAgain) {
  write("a.ppm", "P6\n64 48\n255\n" + std::string(64 * 48 * 3, '\0'));
  const std::string list = write("list.csv", kHeader + "a.ppm," + kTips + "\n");
  const std::string options = "--stills " + list + " --report '" + file("the report") + "'";
  ASSERT_EQ(run(options), 0) << contents(file("stderr"));
  EXPECT_NE(contents(file("the report/report.html")).find("evaluate " + options + "</dd>"),
            std::string::npos);
}

TEST_F(EvaluateCli, AReportThatCannotBeWrittenIsToldBeforeTheWork) {
  fs::create_directories(root_ / "taken" / "report.html");
  expect_refused(kVideo + " --report " + file("taken"), 1, "report.html");
  EXPECT_FALSE(fs::exists(root_ / "taken" / "errors.csv"));
}

TEST_F(EvaluateCli, ABrokenVideoOfATreeIsToldAndCountsAsFarAsItGoes) {
  fs::create_directories(root_ / "tree" / "half");
  fs::copy_file(kVideo, root_ / "tree" / "half" / "video.mp4");
  fs::resize_file(root_ / "tree" / "half" / "video.mp4", fs::file_size(kVideo) / 2);
  EXPECT_EQ(run(file("tree") + " --report " + file("report")), 1);
  EXPECT_NE(contents(file("stderr")).find("video.mp4: breaks off"), std::string::npos);
  EXPECT_TRUE(fs::exists(file("report/distribution.md")));
}

TEST_F(EvaluateCli, AnInterruptLeavesNoReport) {
  const std::string report = file("report"), err = file("stderr");
  const pid_t child = ::fork();
  if (child == 0) {
    std::freopen(err.c_str(), "w", stderr);
    ::execl(HANDYAR_PROGRAM, "handyar", "evaluate", kVideo.c_str(), "--report", report.c_str(),
            nullptr);
    ::_exit(99);
  }
  while (!fs::exists(report)) std::this_thread::yield();  // the work begins after it is there
  ::kill(child, SIGINT);
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(WIFEXITED(status) ? WEXITSTATUS(status) : -1, 130);
  EXPECT_EQ(contents(err), "handyar: interrupted, nothing was written\n");
  EXPECT_FALSE(fs::exists(report));
}

TEST_F(EvaluateCli, OptionsThatCannotBeAreWrongUsage) {
  expect_refused(kVideo + " --report ''", 2, "--report");
  for (const char* board : {"8x60000", "8", "2x6", "8x6 "})
    expect_refused(kVideo + " --square-mm 20 --board '" + board + "' --report " + file("report"), 2,
                   "is not like 8x6");
}

TEST_F(EvaluateCli, OptionsWithoutEffectAreWrongUsage) {
  const std::string report = " --report " + file("report"), hand = kVideo + "/../hand.json";
  fs::create_directories(root_ / "tree");
  for (const char* print : {"--board 8x6 --square-mm 20", "--aruco-mm 80", "--apriltag-mm 60"})
    expect_refused(file("tree") + " " + print + report, 2, "of a tree neither board nor markers");
  const std::string list = write("list.csv", kHeader + "a.jpg," + kTips + "\n");
  for (const std::string& option : {std::string("--uncalibrated"), "--hand " + hand,
                                    "--camera " + hand, std::string("--aruco-mm 80")})
    expect_refused("--stills " + list + " " + option + report, 2, "photographs alone");
  expect_refused(kVideo + " --uncalibrated --hand " + hand + report, 2, "excludes");
}

TEST_F(EvaluateCli, TheListOfStillsIsNotWrittenOver) {
  const std::string list = write("stills.csv", kHeader + "a.jpg," + kTips + "\n");
  const std::string before = contents(list);
  expect_refused("--stills " + list + " --report " + file("."), 2, "stills.csv");
  EXPECT_EQ(contents(list), before);
}

}  // namespace
}  // namespace handyar
