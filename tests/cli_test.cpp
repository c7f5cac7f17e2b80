// SPDX-License-Identifier: MIT
// What is common to all commands: usage, help, faults, and what is remembered.
#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>

#include "command_line.hpp"

namespace handyar {
namespace {

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
        "track " + kVideo + " --poses -",
        "world " + kVideo + " --events -",
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

TEST_F(CliTest, PicturesThatTheShellNamedAreToBeGivenAsAPattern) {
  const Outcome r = run("track ser/1.png ser/2.png ser/3.png --poses " + out("p.csv"));
  EXPECT_EQ(r.code, 2);
  EXPECT_NE(r.err.find("give a pattern, such as ser/%04d.png"), std::string::npos) << r.err;
  EXPECT_EQ(lines(r.err), 1);
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

TEST_F(CliTest, StandardOutputThatIsFullIsAFault) {
  for (const char* arguments : {"cameras", "--version", "track --help", "setup"}) {
    const std::string command = std::string("'" HANDYAR_PROGRAM "' ") + arguments;
    const int status = std::system((command + " >/dev/full 2>" + out("err")).c_str());
    EXPECT_EQ(WEXITSTATUS(status), 1) << arguments;
    EXPECT_EQ(contents(out("err")), "handyar: standard output: cannot be written\n");
  }
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

TEST_F(CliTest, SetupForgetsNothingBeforeAllIsKnownToBeGood) {
  const std::string camera = " --camera " + kData + "/compare/camera.yml";
  ASSERT_EQ(run("setup" + camera + " --hand " + kData + "/compare/hand.json").code, 0);
  const std::string before = run("setup").out;
  const std::string other = " --camera " + kData + "/sample/camera.yml";
  const std::string held = contents(root_ / "config/handyar/camera.yml");
  for (const auto& [arguments, code] :
       std::map<std::string, int>{{"--forget --hand " + in("no.json"), 1},
                                  {"--forget --span-mm 190", 2},
                                  {"--forget " + in("no.mp4"), 1},
                                  {"--forget " + kVideo, 2},
                                  {other + " --hand " + in("no.json"), 1}}) {
    EXPECT_EQ(run("setup " + arguments).code, code) << arguments;
    EXPECT_EQ(run("setup").out, before) << arguments;
    EXPECT_EQ(contents(root_ / "config/handyar/camera.yml"), held) << arguments;
  }
  EXPECT_EQ(run("setup --forget" + other).code, 0);
  const std::string after = run("setup").out;
  EXPECT_NE(after.find("hand         none"), std::string::npos) << after;
}

TEST_F(CliTest, WhereNoInputIsGivenTheRememberedCameraIsTaken) {
  fs::create_directories(root_ / "config/handyar");
  std::ofstream(root_ / "config/handyar/input") << "/dev/video987\n";
  for (const std::string& command :
       {std::string("track"), std::string("world"),
        "inspect --scene " + kData + "/scene_select.json",
        "calibrate --board 8x6 --square-mm 22 --camera-out " + out("c.yml")}) {
    const Outcome r = run(command);
    EXPECT_EQ(r.code, 1) << command;
    EXPECT_EQ(r.err.rfind("handyar: /dev/video987: ", 0), 0u) << r.err;
  }
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
