// SPDX-License-Identifier: MIT
// `handyar calibrate` and `handyar board` as their users meet them, on a rendered recording.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "calibration_scene.hpp"
#include "handyar/calibration/board.hpp"
#include "handyar/io/camera_file.hpp"
#include "handyar/io/hand_file.hpp"
#include "temporary_folder.hpp"

namespace fs = std::filesystem;

namespace handyar {
namespace {

using testing::tips_rms_mm;

const std::string kData = HANDYAR_DATA_DIR;
const std::string kRecording = kData + "/calibrate/video.mp4";
const std::string kCamera = kData + "/calibrate/camera.yml";

struct Outcome {
  int code;
  std::string out, err;
};

class CalibrateCli : public ::testing::Test {
 protected:
  std::string file(const std::string& name) const { return folder_ / name; }

  Outcome run(const std::string& arguments) const {
    const auto contents = [](const std::string& path) {
      std::ostringstream text;
      text << std::ifstream(path, std::ios::binary).rdbuf();
      return text.str();
    };
    const int status = std::system(("'" HANDYAR_PROGRAM "' " + arguments + " >" + file("stdout") +
                                    " 2>" + file("stderr") + " </dev/null")
                                       .c_str());
    return {WEXITSTATUS(status), contents(file("stdout")), contents(file("stderr"))};
  }

  const test::TemporaryFolder folder_;
};

TEST_F(CalibrateCli, CameraAndHandFromOneRecording) {
  const Outcome r = run("calibrate " + kRecording + " --board 8x6 --square-mm 22 --camera-out " +
                        file("camera.yml") + " --hand-out " + file("hand.json") + " --picture " +
                        file("hand.png"));
  ASSERT_EQ(r.code, 0) << r.err;
  EXPECT_NE(r.out.find("camera: focal length"), std::string::npos) << r.out;
  EXPECT_NE(r.out.find("above the board"), std::string::npos) << r.out;

  const Camera truth = io::read_camera(kCamera), camera = io::read_camera(file("camera.yml"));
  EXPECT_NEAR(camera.fx_px / truth.fx_px, 1, 0.01);
  EXPECT_NEAR(camera.cx_px, truth.cx_px, 3);
  EXPECT_NEAR(camera.cy_px, truth.cy_px, 3);
  // OpenCV's own reader takes it too.
  cv::Mat K;
  cv::FileStorage(file("camera.yml"), cv::FileStorage::READ)["camera_matrix"] >> K;
  EXPECT_DOUBLE_EQ(K.at<double>(0, 0), camera.fx_px);

  const HandModel hand = io::read_hand(file("hand.json"));
  EXPECT_LT(tips_rms_mm(hand, io::read_hand(kData + "/calibrate/hand.json")), 1.0);
  EXPECT_EQ(hand.layout, Layout::thumb_right);
  EXPECT_EQ(hand.source, HandSource::checkerboard);
  EXPECT_TRUE(hand.figure);
  EXPECT_GT(hand.tips_sigma_m.minCoeff(), 0);
  EXPECT_FALSE(cv::imread(file("hand.png")).empty());
}

TEST_F(CalibrateCli, ThePapersWayWithAKnownCamera) {
  const Outcome r = run("calibrate " + kRecording + " --board 8x6 --square-mm 22 --camera " +
                        kCamera + " --method plane --hand-out " + file("hand.json"));
  ASSERT_EQ(r.code, 0) << r.err;
  EXPECT_EQ(r.out.find("camera:"), std::string::npos) << "only the hand is measured";
  const HandModel hand = io::read_hand(file("hand.json"));
  EXPECT_LT(tips_rms_mm(hand, io::read_hand(kData + "/calibrate/hand.json")), 2.0);
  char told[64];
  std::snprintf(told, sizeof told, "hand: %.1f mm from thumb tip", 1000 * hand.span_m());
  EXPECT_NE(r.out.find(told), std::string::npos) << "what is written is told: " << r.out;
  std::snprintf(told, sizeof told, "%.2f px rms", hand.rms_px);
  EXPECT_NE(r.out.find(told), std::string::npos) << r.out;
}

TEST_F(CalibrateCli, WithoutABoardFromTheHandsMotion) {
  const HandModel truth = io::read_hand(kData + "/sample/hand.json");
  const std::string sample = "calibrate sample --self --camera " + kData + "/sample/camera.yml";
  const Outcome r = run(sample + " --span-mm " + std::to_string(1000 * truth.span_m()) +
                        " --hand-out " + file("hand.json"));
  ASSERT_EQ(r.code, 0) << r.err;
  const HandModel hand = io::read_hand(file("hand.json"));
  EXPECT_LT(tips_rms_mm(hand, truth), 0.03 * 1000 * truth.span_m());
  EXPECT_EQ(hand.source, HandSource::self);
  EXPECT_FALSE(hand.scale_assumed());

  const Outcome assumed = run(sample + " --hand-out " + file("average.json"));
  ASSERT_EQ(assumed.code, 0) << assumed.err;
  EXPECT_NE(assumed.out.find("the size the average adult's"), std::string::npos) << assumed.out;
  EXPECT_TRUE(io::read_hand(file("average.json")).scale_assumed());
}

// A left hand's back was measured beside the board; the sample shows a right palm: one model, since
// both have the thumb on the right. Mirrored it would not fit.
TEST_F(CalibrateCli, AModelOfTheLeftHandServesTheRightPalm) {
  const Outcome r = run("calibrate " + kRecording + " --board 8x6 --square-mm 22 --camera " +
                        kCamera + " --hand-out " + file("hand.json"));
  ASSERT_EQ(r.code, 0) << r.err;
  const HandModel left = io::read_hand(file("hand.json"));
  const HandModel right = io::read_hand(kData + "/sample/hand.json");
  EXPECT_LT(tips_rms_mm(left.for_layout(Layout::thumb_right), right), 1.0);
  EXPECT_GT(tips_rms_mm(left.for_layout(Layout::thumb_left), right), 20);
}

TEST_F(CalibrateCli, BadRecordingsAreRefusedInOneLine) {
  const std::string hand = " --hand-out " + file("hand.json");
  const auto refused = [&](const std::string& arguments) {
    const Outcome r = run("calibrate " + arguments + hand);
    EXPECT_EQ(r.code, 1) << arguments << r.err;
    EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
    EXPECT_FALSE(fs::exists(file("hand.json")));
    return r.err;
  };
  const std::string counts = refused(kRecording + " --board 9x7 --square-mm 22");
  EXPECT_NE(counts.find("one of 8x6"), std::string::npos) << counts;
  const std::string size = refused(kRecording + " --board 8x6 --square-mm 60 --camera " + kCamera);
  EXPECT_NE(size.find("squares really 60 mm"), std::string::npos) << size;
  const std::string none = refused("sample --board 8x6 --square-mm 22");
  EXPECT_NE(none.find("seen in 0 of"), std::string::npos) << none;
}

TEST_F(CalibrateCli, AHandWhosePictureCannotBeWrittenIsNotWritten) {
  fs::create_symlink("/dev/full", file("hand.png"));
  const Outcome r = run("calibrate " + kRecording + " --board 8x6 --square-mm 22 --camera-out " +
                        file("camera.yml") + " --hand-out " + file("hand.json") + " --picture " +
                        file("hand.png"));
  EXPECT_EQ(r.code, 1) << r.err;
  EXPECT_FALSE(fs::exists(file("hand.json")));
  EXPECT_FALSE(fs::exists(file("camera.yml")));
}

TEST_F(CalibrateCli, WrongUsageIsCode2) {
  for (const std::string& arguments :
       {kRecording, kRecording + " --board 8x6 --hand-out h.json",
        kRecording + " --board 8by6 --square-mm 22 --hand-out h.json",
        kRecording + " --self --hand-out h.json",
        kRecording + " --self --camera " + kCamera + " --square-mm 22 --hand-out h.json",
        kRecording + " --board 8x6 --square-mm 22",
        kRecording + " --board 8x6 --square-mm 22 --hand-out a --camera-out a"}) {
    const Outcome r = run("calibrate " + arguments);
    EXPECT_EQ(r.code, 2) << arguments << r.err;
    EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
  }
  EXPECT_EQ(run("board --out b.gif").code, 2);
  EXPECT_EQ(run("board --out b.pdf --squares 3").code, 2);
}

TEST_F(CalibrateCli, BoardsAreMadeToPrintAndToShow) {
  ASSERT_EQ(run("board --out " + file("b.pdf")).code, 0);
  EXPECT_GT(fs::file_size(file("b.pdf")), 1000u);
  ASSERT_EQ(run("board --out " + file("b.png") + " --squares 7x6").code, 0);
  const Board board{6, 5, 0.025};
  EXPECT_EQ(find_board(cv::imread(file("b.png")), board).size(), 30u);
}

}  // namespace
}  // namespace handyar
