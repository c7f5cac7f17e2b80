// SPDX-License-Identifier: MIT
// Files and inputs of handyar::io: what is written is read back, what is wrong is named.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <clocale>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <future>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <sstream>

#include "handyar/io/camera_file.hpp"
#include "handyar/io/cameras.hpp"
#include "handyar/io/error.hpp"
#include "handyar/io/frame_source.hpp"
#include "handyar/io/hand_file.hpp"
#include "handyar/io/latest_frame.hpp"
#include "handyar/io/pending_file.hpp"
#include "handyar/io/pose_csv.hpp"
#include "handyar/io/quiet_standard_error.hpp"
#include "handyar/io/recording.hpp"
#include "handyar/io/sample.hpp"
#include "handyar/io/video_writer.hpp"
#include "handyar/tracker.hpp"
#include "temporary_folder.hpp"

namespace fs = std::filesystem;

namespace handyar::io {
namespace {

// A folder of its own for each test.
class IoTest : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::size_t files() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }
  const test::TemporaryFolder temporary_;
  const fs::path& folder_ = temporary_.path();
};

template <typename F>
std::string fault_of(F&& f) {
  try {
    f();
  } catch (const Error& e) {
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
    return e.what();
  }
  return "";
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const auto at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return at == std::string::npos ? text : text.replace(at, what.size(), by);
}

std::string repeated(const std::string& text, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

std::string camera_text() { return read_text(data_file("sample/camera.yml")); }
std::string hand_text() { return read_text(data_file("sample/hand.json")); }

// Red, green, blue and white quarters, so that every turn of the picture shows.
cv::Mat quarters(int width, int height) {
  cv::Mat picture(height, width, CV_8UC3, cv::Scalar(255, 255, 255));
  picture(cv::Rect(0, 0, width / 2, height / 2)).setTo(cv::Scalar(0, 0, 255));
  picture(cv::Rect(width / 2, 0, width / 2, height / 2)).setTo(cv::Scalar(0, 255, 0));
  picture(cv::Rect(0, height / 2, width / 2, height / 2)).setTo(cv::Scalar(255, 0, 0));
  return picture;
}

// The quarters' colours, row by row: "RGBW" when upright.
std::string colors(const cv::Mat& picture) {
  std::string text;
  for (const int y : {picture.rows / 4, 3 * picture.rows / 4}) {
    for (const int x : {picture.cols / 4, 3 * picture.cols / 4}) {
      const auto c = picture.at<cv::Vec3b>(y, x);
      const int bits = (c[2] > 128) * 4 + (c[1] > 128) * 2 + (c[0] > 128);
      text += std::string("?B?GR??W")[static_cast<std::size_t>(bits == 2 ? 3 : bits)];
    }
  }
  return text;
}

void write_video(const std::string& path, int frames) {
  VideoWriter writer(path, 160, 120, 25);
  for (int i = 0; i < frames; ++i) {
    cv::Mat picture = quarters(160, 120);
    cv::circle(picture, {20 + 3 * i, 60}, 10, {0, 0, 0}, cv::FILLED);
    writer.write(picture, i / 25.0);
  }
  writer.finish();
}

std::vector<double> times_of(FrameSource& source) {
  std::vector<double> times;
  for (Frame frame; source.read(frame);) times.push_back(frame.time_s);
  return times;
}

TEST_F(IoTest, CameraIsReadBackAsWritten) {
  Camera camera = Camera::from_field_of_view(1280, 720);
  camera.fy_px = 1111.0 / 3.0;
  camera.distortion = {0.1, -0.2, 1e-5, 0, 12.5};
  camera.readout_s = 0.025;
  write_camera(path("camera.yml"), camera);
  const Camera read = read_camera(path("camera.yml"));
  EXPECT_EQ(read.width_px, 1280);
  EXPECT_EQ(read.height_px, 720);
  EXPECT_EQ(read.fx_px, camera.fx_px);
  EXPECT_EQ(read.fy_px, camera.fy_px);
  EXPECT_EQ(read.cx_px, camera.cx_px);
  EXPECT_EQ(read.cy_px, camera.cy_px);
  EXPECT_EQ(read.distortion, camera.distortion);
  EXPECT_EQ(read.readout_s, 0.025);
  EXPECT_TRUE(read.assumed) << "an assumed camera does not become a calibrated one in a file";
  camera.assumed = false;
  write_camera(path("camera.yml"), camera);
  EXPECT_FALSE(read_camera(path("camera.yml")).assumed);
  EXPECT_EQ(files(), 1u);
}

TEST_F(IoTest, CameraFileMayBeginWithAByteOrderMark) {
  EXPECT_EQ(parse_camera("\xef\xbb\xbf" + camera_text(), "c.yml").width_px, 640);
}

TEST_F(IoTest, RosCameraFileIsRead) {
  const Camera camera = parse_camera(
      "image_width: 640\nimage_height: 480\ncamera_name: cam\n"
      "camera_matrix:\n  rows: 3\n  cols: 3\n  data: [600, 0, 320.5, 0, 601, 240, 0, 0, 1]\n"
      "distortion_model: plumb_bob\n"
      "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0.1, 0, 0, 0, 0]\n",
      "ros.yaml");
  EXPECT_EQ(camera.fx_px, 600);
  EXPECT_EQ(camera.cx_px, 320.5);
  EXPECT_EQ(camera.distortion[0], 0.1);
}

TEST_F(IoTest, FaultyCameraFilesAreRefusedByField) {
  const struct {
    const char *what, *by, *fault;
  } cases[] = {
      {"[ 618.0", "[ .nan", "camera_matrix: number 1 is not finite"},
      {"[ 618.0", "[ .Inf", "camera_matrix: number 1 is not finite"},
      {"[ 618.0", "[ nan", "camera_matrix: number 1 is not a number"},
      {"[ 618.0", "[ -618.0", "camera_matrix: a focal length is not positive"},
      {"[ 618.0", "[ 0.618", "camera_matrix: a focal length does not fit the picture's size"},
      {"[ 618.0, 0.0", "[ 618.0, 3.0", "camera_matrix is not of the form fx 0 cx, 0 fy cy, 0 0 1"},
      {"322.38", "3223.8", "camera_matrix: the principal point is outside the picture"},
      {"cols: 3", "cols: 4", "camera_matrix: rows, cols and the count of its numbers disagree"},
      {"image_width: 640", "image_width: 0", "image_width must be a whole number from 1 to 65536"},
      {"image_width: 640", "width: 640", "image_width is missing"},
      {"image_height: 480", "image_height: tall",
       "image_height must be a whole number from 1 to 65536"},
      {"distortion_coefficients", "distortion", "distortion_coefficients is missing"},
      {"[ 0.0, 0.0, 0.0, 0.0, 0.0 ]", "[ 0.0, 0.0, .nan, 0.0, 0.0 ]",
       "distortion_coefficients: number 3 is not finite"},
      {"[ 0.0, 0.0, 0.0, 0.0, 0.0 ]", "[ 0.0, 0.0, 50.0, 50.0, 0.0 ]",
       "distortion_coefficients fold the picture over itself"},
      {"[ 0.0, 0.0, 0.0, 0.0, 0.0 ]", "[ -3.0, 0.0, 0.0, 0.0, 0.0 ]",
       "distortion_coefficients fold the picture over itself"},
      {"[ 0.0, 0.0, 0.0, 0.0, 0.0 ]", "[ -0.41, 0.19, 0.001, -0.002, -0.05 ]", ""},
      {"cols: 5\n   dt: d\n   data: [ 0.0, 0.0, ", "cols: 3\n   dt: d\n   data: [ ",
       "distortion_coefficients: 4, 5 or 8 numbers are expected, not 3"},
      {"cols: 5\n   dt: d\n   data: [ ", "cols: 8\n   dt: d\n   data: [ 0.0, 0.0, 0.0, ", ""},
      {"cols: 5\n   dt: d\n   data: [ 0.0, 0.0, 0.0, 0.0, 0.0",
       "cols: 8\n   dt: d\n   data: [ 0., 0., 0., 0., 0., 0.1, 0., 0.",
       "distortion_coefficients: k4, k5, k6 are not supported, only zero"},
      {"image_width", "readout_s: 0.02\nimage_width", ""},
      {"image_width", "readout_s: 25\nimage_width", "readout_s must be a number from 0 to 0.1"},
      {"image_width", "readout_s: .nan\nimage_width", "readout_s must be a number from 0 to 0.1"},
      {"image_width", "readout_s: all\nimage_width", "readout_s must be a number from 0 to 0.1"},
      {"image_width", "assumed: 1\nimage_width", ""},
      {"image_width", "assumed: yes\nimage_width", "assumed must be 0 or 1"},
      {"image_width", "assumed: 2\nimage_width", "assumed must be 0 or 1"},
  };
  for (const auto& c : cases) {
    const std::string text = replaced(camera_text(), c.what, c.by);
    const std::string fault = fault_of([&] { parse_camera(text, "c.yml"); });
    EXPECT_EQ(fault, *c.fault ? std::string("c.yml: ") + c.fault : "") << c.by;
  }
  for (const std::string& text : std::initializer_list<std::string>{
           "", "hello", "%YAML:1.0\n---\n- a\n", "{", "\x01\x02\xff", "%YAML:1.0\n---\n   :dt ls",
           "%YAML:1.0\n---\nimage_width: [", "<?xml version=\"1.0\"?>",
           // found by fuzzing: OpenCV 4.6 alone never returns from these
           "%YAML:1.0\n---------%YAML:1.0\n---\n--/---ig. :---a_m,", "a: 1\n-x",
           "\n \xdb%YAML:1.0\n-\xa6-\nimage_width: 640\nimage_height: 480\n"
           "camera_matrix: !!opencv\xb6:-.-mia",
           // OpenCV alone runs out of stack
           "a: " + std::string(200000, '['), "{\"a\": " + std::string(200000, '['),
           "a:\n  " + repeated("- ", 200000), "a:\n  " + std::string(200000, '-') + "x",
           repeated("a: ", 200000) + "x", "a: " + repeated("{b: ", 200000),
           "<?xml version=\"1.0\"?>\n<opencv_storage>" + repeated("<a>", 200000)}) {
    EXPECT_NE(fault_of([&] { parse_camera(text, "c.yml"); }), "") << text.substr(0, 100);
  }
  EXPECT_EQ(fault_of([] { parse_camera("a: 1\nb: [ 1,\nc: 2 ]\n", "c.yml"); }),
            "c.yml: is not a camera file (YAML): line 3: Incorrect indentation");
}

TEST_F(IoTest, CameraFitsOtherSizesOfTheSameShapeOnly) {
  const Camera assumed = Camera::from_field_of_view(1280, 960);
  EXPECT_EQ(camera_for_size(assumed, 960, 1280, "c.yml").fx_px, assumed.fx_px);
  Camera camera = assumed;
  camera.assumed = false;
  const Camera half = camera_for_size(camera, 640, 480, "c.yml");
  EXPECT_EQ(half.width_px, 640);
  EXPECT_NEAR(half.fx_px, camera.fx_px / 2, 1e-9);
  EXPECT_EQ(fault_of([&] { camera_for_size(camera, 1280, 720, "c.yml"); }),
            "c.yml: is for pictures of 1280x960 pixels, the input has 1280x720: another shape, so "
            "it cannot be scaled to it");
}

TEST_F(IoTest, HandIsReadBackAsWritten) {
  HandModel hand = average_adult_hand().for_layout(Layout::thumb_left);
  hand.source = HandSource::checkerboard;
  hand.rms_px = 1.0 / 3.0;
  hand.tips_sigma_m.setZero();
  write_hand(path("1.json"), hand);
  HandModel read = read_hand(path("1.json"));
  EXPECT_EQ(read.tips_m, hand.tips_m);
  EXPECT_EQ(read.layout, hand.layout);
  EXPECT_EQ(read.source, hand.source);
  EXPECT_EQ(read.rms_px, hand.rms_px);
  EXPECT_EQ(read.thickness_m, hand.thickness_m);
  EXPECT_FALSE(read.figure);

  hand.tips_sigma_m.setConstant(0.001);
  write_hand(path("2.json"), hand);
  EXPECT_EQ(read_hand(path("2.json")).tips_sigma_m, hand.tips_sigma_m);

  hand.figure = FigureEstimate{};
  hand.figure->mean.setRandom();
  hand.figure->covariance *= 0.25;
  hand.figure->covariance(2, 5) = hand.figure->covariance(5, 2) = 0.1;
  write_hand(path("4.json"), hand);
  EXPECT_NE(read_text(path("4.json")).find("\"version\": 4"), std::string::npos);
  read = read_hand(path("4.json"));
  ASSERT_TRUE(read.figure);
  EXPECT_EQ(read.figure->mean, hand.figure->mean);
  EXPECT_EQ(read.figure->covariance, hand.figure->covariance);
  hand.figure->covariance(0, 0) = -1;
  EXPECT_NE(fault_of([&] { parse_hand(format_hand(hand), "h.json"); }).find("h.json: figure"),
            std::string::npos);
}

TEST_F(IoTest, FaultyHandFilesAreRefusedByField) {
  const struct {
    const char *what, *by, *fault;
  } cases[] = {
      {"\"little\"", "\"pinky\"", "tips_m: there is no pinky on a hand"},
      {"handyar-hand", "hand", "format is not handyar-hand"},
      {"\"version\": 1", "\"version\": 5", "version 5 is not known, only 1 to 4"},
      {"\"version\": 1", "\"version\": 0", "version 0 is not known, only 1 to 4"},
      {"\"version\": 1", "\"version\": 1.5", "version is not a whole number"},
      {"0.093328608", "93.328608", "tips_m: thumb is too far off: the unit is the metre"},
      {"0.093328608", "\"wide\", 0.09", "tips_m: thumb is not [x, y, z]"},
      {"0.093328608", "null, \"", "is not valid JSON"},
      {"0.093328608", "1e999, 0", "is not valid JSON"},
      {"-0.063423204", "0.063423204", "tips_m: thumb and little finger are 46 mm apart"},
      {"thumb_right", "left", "layout is neither thumb_right nor thumb_left"},
      {"thumb_right", "thumb_left", "layout is thumb_left, but the thumb"},
      {"\"truth\"", "\"guess\"", "source is none of checkerboard, default, self, truth"},
      {"\"source\"", "\"origin\"", "source is missing"},
      {"\"rms_px\": 0.0", "\"rms_px\": -1", "rms_px is beyond reason"},
      {"\"thickness_m\": 0.005", "\"thickness_m\": \"5 mm\"", "thickness_m is not a number"},
      {"-0.002473863", "0.4", "tips_m: thumb is 320 mm off the plane of the others"},
  };
  for (const auto& c : cases) {
    const std::string text = replaced(hand_text(), c.what, c.by);
    const std::string fault = fault_of([&] { parse_hand(text, "h.json"); });
    EXPECT_EQ(fault.rfind(std::string("h.json: ") + c.fault, 0), 0u) << fault;
  }
  EXPECT_EQ(fault_of([&] { parse_hand(hand_text() + std::string(1 << 16, ' '), "h.json"); }),
            "h.json: is larger than 64 KiB: not a hand file");
  std::string swapped = replaced(hand_text(), "\"index\"", "\"?\"");
  swapped = replaced(replaced(swapped, "\"ring\"", "\"index\""), "\"?\"", "\"ring\"");
  EXPECT_EQ(fault_of([&] { parse_hand(swapped, "h.json"); }),
            "h.json: tips_m: the fingers do not lie in order from thumb to little");
  HandModel line = parse_hand(hand_text(), "h.json");
  for (int i = 0; i < kFingerCount; ++i) line.tips_m.col(i) << 0.08 - 0.04 * i, 0, 0;
  EXPECT_EQ(fault_of([&] { parse_hand(format_hand(line), "h.json"); }),
            "h.json: tips_m: the fingers do not lie in order from thumb to little");
  std::string four = hand_text();
  const auto at = four.find(",\n  \"little\"");
  ASSERT_NE(at, std::string::npos);
  four.erase(at, four.find(']', at) + 1 - at);
  EXPECT_EQ(fault_of([&] { parse_hand(four, "h.json"); }), "h.json: tips_m: little is missing");
  for (const std::string& text :
       std::initializer_list<std::string>{"", "[]", "7", "{", "{\"format\": 1}", "\"\\u0000\""}) {
    EXPECT_NE(fault_of([&] { parse_hand(text, "h.json"); }), "") << text;
  }
}

TEST_F(IoTest, PoseRowsAreTheSameInEveryLocale) {
  TrackResult result;
  result.time_s = 1.0 / 3.0;
  EXPECT_EQ(pose_csv_row(7, result, false),
            "7,0.333333,searching,,,,,,,,,,,,,,,,,,,,,,,,,,,,,,,,,,,0,,1");
  result.state = State::tracking;
  result.layout = Layout::thumb_left;
  result.tips[0] = {{1.5, -2.25}, true};
  PoseEstimate raw;
  raw.T_camera_hand.linear() = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()).matrix();
  raw.T_camera_hand.translation() = Eigen::Vector3d(0, 0.01, 0.5);
  raw.rms_px = 0.5;
  raw.covariance.setIdentity();
  result.raw_pose = raw;
  result.times.total_ms = 0.25;
  const std::string row = pose_csv_row(7, result);
  EXPECT_NE(row.find("7,0.333333,tracking,thumb_left,1.500,-2.250,,,"), std::string::npos) << row;
  EXPECT_NE(row.find("1.000000000,0.000000000,0.000000000,0.0000000,0.0100000,0.5000000,0.500,"
                     "1.000000000,1.000000000,"),
            std::string::npos)
      << row;
  const auto commas = [](std::string_view text) {
    return std::count(text.begin(), text.end(), ',');
  };
  EXPECT_EQ(commas(row), commas(kPoseCsvHeader));
  for (const char* locale : {"de_DE.UTF-8", "fr_FR.UTF-8", "de_DE"}) {
    if (std::setlocale(LC_ALL, locale) == nullptr) continue;
    EXPECT_EQ(pose_csv_row(7, result), row);
  }
  std::setlocale(LC_ALL, "C");
}

TEST_F(IoTest, PoseFileTakesItsNameAtTheEnd) {
  {
    PoseCsvWriter abandoned(path("p.csv"));
    abandoned.write(0, {});
    EXPECT_FALSE(fs::exists(path("p.csv")));
  }
  EXPECT_EQ(files(), 0u);
  write_text(path("p.csv"), "older");
  PoseCsvWriter writer(path("p.csv"));
  writer.write(0, {});
  EXPECT_EQ(read_text(path("p.csv")), "older");
  writer.finish();
  const std::string text = read_text(path("p.csv"));
  EXPECT_EQ(text.rfind(std::string(kPoseCsvHeader) + "\n0,0.000000,searching,", 0), 0u);
  EXPECT_EQ(files(), 1u);
}

TEST_F(IoTest, WhatIsNoRegularFileIsWrittenDirectly) {
  PoseCsvWriter writer("/dev/null");
  writer.write(0, {});
  writer.finish();
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  fs::create_symlink("target.txt", path("link.txt"));
  write_text(path("target.txt"), "old");
  write_text(path("link.txt"), "new");
  EXPECT_TRUE(fs::is_symlink(path("link.txt")));
  EXPECT_EQ(read_text(path("target.txt")), "new");
}

TEST_F(IoTest, WhatIsOpenAlreadyIsWrittenOn) {
  write_text(path("all.csv"), "before\n");
  const int file = ::open(path("all.csv").c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  fs::create_symlink("/dev/fd/" + std::to_string(file), path("link.csv"));
  write_text("/dev/fd/" + std::to_string(file), "new\n");
  write_text(path("link.csv"), "newer\n");
  ::close(file);
  EXPECT_EQ(read_text(path("all.csv")), "before\nnew\nnewer\n");
}

TEST_F(IoTest, APipeIsOpenedOnce) {
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  auto reader = std::async(std::launch::async, [&] { return read_text(path("pipe")); });
  write_text(path("pipe"), "all of it");
  EXPECT_EQ(reader.get(), "all of it");
}

TEST_F(IoTest, WhatALinkLeadsToIsMade) {
  fs::create_symlink("second.txt", path("first.txt"));
  fs::create_symlink("target.txt", path("second.txt"));
  write_text(path("first.txt"), "new");
  EXPECT_TRUE(fs::is_symlink(path("first.txt")));
  EXPECT_TRUE(fs::is_symlink(path("second.txt")));
  EXPECT_EQ(read_text(path("target.txt")), "new");
  EXPECT_EQ(files(), 3u);
}

TEST_F(IoTest, StandardErrorComesBackWhenTheLastHasEnded) {
  const auto null = [] {
    struct stat a, b;
    ::fstat(STDERR_FILENO, &a);
    ::stat("/dev/null", &b);
    return a.st_rdev == b.st_rdev;
  };
  const int before = ::dup(STDERR_FILENO);
  const int file = ::open(path("err").c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
  ::dup2(file, STDERR_FILENO);
  auto first = std::make_optional<QuietStandardError>();  // as two threads may have it
  auto second = std::make_optional<QuietStandardError>();
  first.reset();
  const bool quiet = null();
  second.reset();
  const bool loud = !null();
  ::dup2(before, STDERR_FILENO);
  ::close(before);
  ::close(file);
  EXPECT_TRUE(quiet);
  EXPECT_TRUE(loud);
}

TEST_F(IoTest, AFileThatIsReplacedKeepsItsPermissions) {
  write_text(path("p.csv"), "old");
  const auto owner_only = fs::perms::owner_read | fs::perms::owner_write;
  fs::permissions(path("p.csv"), owner_only);
  write_text(path("p.csv"), "new");
  EXPECT_EQ(read_text(path("p.csv")), "new");
  EXPECT_EQ(fs::status(path("p.csv")).permissions(), owner_only);
}

TEST_F(IoTest, NamesMayBeAsLongAsTheSystemAllows) {
  const std::string name = path(std::string(251, 'n') + ".txt");
  write_text(name, "new");
  EXPECT_EQ(read_text(name), "new");
  EXPECT_EQ(files(), 1u);
}

TEST_F(IoTest, WhatAKilledRunLeftIsRemovedByTheNext) {
  const pid_t child = ::fork();
  if (child == 0) {
    const PendingFile file(path("p.csv"));
    ::raise(SIGKILL);
  }
  ::waitpid(child, nullptr, 0);
  EXPECT_EQ(files(), 1u);
  write_text(path("p.partial-notes.csv"), "not ours");
  PendingFile running(path("p.csv"));
  EXPECT_EQ(files(), 2u);
  {
    const PendingFile again(path("q.csv"));
    write_text(path("p2.csv"), "");
  }
  const pid_t other = ::fork();
  if (other == 0) {
    { const PendingFile file(path("p.csv")); }
    ::_exit(0);
  }
  ::waitpid(other, nullptr, 0);
  EXPECT_TRUE(fs::exists(running.path())) << "another run is still writing it";
  running.commit();
  EXPECT_TRUE(fs::exists(path("p.csv")));
}

TEST_F(IoTest, OutputsThatCannotBeWrittenAreNamed) {
  EXPECT_EQ(
      fault_of([&] { PoseCsvWriter("/proc/p.csv"); }).rfind("/proc/p.csv: cannot be written", 0),
      0u);
  EXPECT_EQ(fault_of([&] { PoseCsvWriter(path("no/p.csv")); }),
            path("no/p.csv") + ": cannot be written: No such file or directory");
  EXPECT_EQ(fault_of([&] { write_text(folder_.string(), ""); }),
            folder_.string() + ": is a folder, not a file");
  EXPECT_EQ(fault_of([&] { VideoWriter(path("v.txt"), 160, 120, 30); }),
            path("v.txt") + ": its name must end in .mp4, .mov, .mkv or .avi");
  EXPECT_EQ(files(), 0u);
}

// Files of this process end at a size, as they would on a full disk.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &limit_);
    const rlimit small{bytes, limit_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &small);
  }
  ~FullDisk() {
    ::setrlimit(RLIMIT_FSIZE, &limit_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  void (*handler_)(int);
  rlimit limit_{};
};

class VideoTest : public IoTest, public testing::WithParamInterface<const char*> {};

TEST_P(VideoTest, VideoIsReadBackAsWritten) {
  const std::string name = path(std::string("v") + GetParam());
  write_video(name, 12);
  EXPECT_EQ(files(), 1u);
  const auto source = open_input(name);
  EXPECT_EQ(source->info().width_px, 160);
  EXPECT_EQ(source->info().height_px, 120);
  EXPECT_NEAR(source->info().fps, 25, 0.01);
  EXPECT_FALSE(source->info().live);
  Frame frame;
  int count = 0;
  for (; source->read(frame); ++count) {
    EXPECT_EQ(frame.index, count);
    EXPECT_NEAR(frame.time_s, count / 25.0, 0.002);
    EXPECT_EQ(colors(frame.bgr), "RGBW");
  }
  EXPECT_EQ(count, 12);
  EXPECT_EQ(frame.view().stride_bytes, 480);
}

TEST_F(IoTest, WrittenVideosKeepToTheTimesOfTheirFrames) {
  // 10 frames at the rate of 25 with some jitter, 5 at half of it, a pause, 10 at twice the rate.
  std::vector<double> times_s;
  for (int i = 0; i < 10; ++i) times_s.push_back((i + 0.3 * (i % 2)) / 25);
  for (int i = 0; i < 5; ++i) times_s.push_back((10 + 2 * i) / 25.0);
  for (int i = 0; i < 10; ++i) times_s.push_back(2 + i / 50.0);
  times_s.push_back(100);
  VideoWriter writer(path("v.avi"), 160, 120, 25);
  for (int i = 0; i < std::ssize(times_s); ++i) {  // its number in five black or white bars
    cv::Mat picture(120, 160, CV_8UC3);
    for (int bit = 0; bit < 5; ++bit)
      picture.colRange(32 * bit, 32 * bit + 32).setTo(cv::Scalar::all(i >> bit & 1 ? 255 : 0));
    writer.write(picture, times_s[std::size_t(i)]);
  }
  writer.finish();
  const auto source = open_input(path("v.avi"));
  std::vector<int> shown;
  for (Frame frame; source->read(frame);) {
    shown.push_back(0);
    for (int bit = 0; bit < 5; ++bit)
      shown.back() += (frame.bgr.at<cv::Vec3b>(60, 32 * bit + 16)[0] > 128) << bit;
  }
  ASSERT_GT(shown.size(), 55u);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(shown[i], i);
  for (std::size_t i = 0; i < 55; ++i)
    EXPECT_LE(std::abs(times_s[shown[i]] - double(i) / 25), i > 18 && i < 50 ? 1.4 : 0.09) << i;
  EXPECT_NEAR(double(shown.size()), 25 * 12.2, 3) << "a long pause is cut short";
}

TEST_P(VideoTest, OddSizesLoseNoRowAndNoColumn) {
  const std::string name = path(std::string("v") + GetParam());
  cv::Mat picture(121, 161, CV_8UC3, cv::Scalar::all(0));
  VideoWriter writer(name, picture.cols, picture.rows, 25);
  picture.row(120).setTo(cv::Scalar::all(255));
  picture.col(160).setTo(cv::Scalar::all(255));
  for (int i = 0; i < 3; ++i) writer.write(picture, i / 25.0);
  writer.finish();
  Frame frame;
  ASSERT_TRUE(open_input(name)->read(frame));
  EXPECT_EQ(frame.bgr.size(), cv::Size(162, 122));
  EXPECT_GT(frame.bgr.at<cv::Vec3b>(120, 80)[1], 180);
  EXPECT_GT(frame.bgr.at<cv::Vec3b>(60, 160)[1], 180);
  EXPECT_LT(frame.bgr.at<cv::Vec3b>(60, 80)[1], 60);
}

TEST_P(VideoTest, VideoThatCannotBeWrittenWholeIsNotKept) {
  const std::string name = path(std::string("v") + GetParam());
  write_video(name, 50);
  const auto size = fs::file_size(name);
  fs::remove(name);
  for (const auto bytes : {size * 9 / 10, size / 2, size / 10, size * 0}) {
    const std::string fault = fault_of([&] {
      const FullDisk disk(bytes);
      write_video(name, 50);
    });
    EXPECT_EQ(fault.rfind(name + ": cannot be written", 0), 0u) << bytes << fault;
    EXPECT_EQ(fault.find("encoder"), std::string::npos) << bytes;
    EXPECT_EQ(files(), 0u) << bytes;
  }
}
INSTANTIATE_TEST_SUITE_P(Containers, VideoTest, testing::Values(".mp4", ".mkv", ".avi", ".mov"),
                         [](const auto& param) { return std::string(param.param + 1); });

// What ffmpeg's own turning makes of the same files; each was made from the same upright-looking
// stream by setting the container's rotation.
TEST_F(IoTest, RecordingsAreReplayedAsTheyWere) {
  const std::vector<double> times_s = {0, 0.033, 0.071, 0.1, 1.25, 1.251};
  std::vector<cv::Mat> pictures;
  cv::RNG random(7);
  Recording recording(path("r.mkv"), 161, 121);
  for (const double time_s : times_s) {
    pictures.emplace_back(121, 161, CV_8UC3);
    random.fill(pictures.back(), cv::RNG::UNIFORM, 0, 256);
    recording.write(pictures.back(), time_s);
  }
  recording.finish();
  EXPECT_EQ(files(), 1u);
  const auto source = open_input(path("r.mkv"));
  Frame frame;
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    ASSERT_TRUE(source->read(frame));
    EXPECT_EQ(cv::norm(frame.bgr, pictures[i], cv::NORM_INF), 0) << i;
    EXPECT_NEAR(frame.time_s, times_s[i], 1e-6) << i;
  }
  EXPECT_FALSE(source->read(frame));

  EXPECT_EQ(fault_of([&] { Recording(path("r.mp4"), 160, 120); }),
            path("r.mp4") + ": its name must end in .mkv");
  const std::string fault = fault_of([&] {
    const FullDisk disk(50000);
    Recording full(path("full.mkv"), 161, 121);
    for (std::size_t i = 0; i < times_s.size(); ++i) full.write(pictures[i], times_s[i]);
    full.finish();
  });
  EXPECT_EQ(fault.rfind(path("full.mkv") + ": cannot be written", 0), 0u) << fault;
  EXPECT_EQ(files(), 1u);
}

TEST_F(IoTest, RotationTagsAreHonoured) {
  const struct {
    const char *file, *colors;
    int width, height;
  } cases[] = {{"none", "RGBW", 160, 120},
               {"quarter_left", "GWRB", 120, 160},
               {"half", "WBGR", 160, 120},
               {"quarter_right", "BRWG", 120, 160}};
  for (const auto& c : cases) {
    const auto source =
        open_input(std::string(HANDYAR_TEST_DATA_DIR) + "/rotated_" + c.file + ".mp4");
    EXPECT_EQ(source->info().width_px, c.width) << c.file;
    EXPECT_EQ(source->info().height_px, c.height) << c.file;
    Frame frame;
    int count = 0;
    for (; source->read(frame); ++count) EXPECT_EQ(colors(frame.bgr), c.colors) << c.file;
    EXPECT_EQ(count, 3) << c.file;
  }
}

TEST_F(IoTest, TimesOfAVideoWithVaryingRateAreItsOwn) {
  // 20 frames at 30 Hz, then 10 at 15 Hz
  const auto source = open_input(std::string(HANDYAR_TEST_DATA_DIR) + "/varying_rate.mp4");
  const std::vector<double> times = times_of(*source);
  ASSERT_EQ(times.size(), 30u);
  for (std::size_t i = 0; i < times.size(); ++i) {
    const double n = static_cast<double>(i);
    EXPECT_NEAR(times[i], i <= 20 ? n / 30 : (20 + 2 * (n - 20)) / 30, 0.001) << i;
  }
}

TEST_F(IoTest, TimesGoOnAfterALongPause) {
  // 20 frames at 30 Hz, 15 s of nothing, then 10 more
  const auto source = open_input(std::string(HANDYAR_TEST_DATA_DIR) + "/pause.mp4");
  const std::vector<double> times = times_of(*source);
  ASSERT_EQ(times.size(), 30u);
  for (std::size_t i = 0; i < times.size(); ++i) {
    EXPECT_NEAR(times[i], static_cast<double>(i) / 30 + (i < 20 ? 0 : 15), 0.001) << i;
  }
}

// Its index lists 60 frames, of which the first 33 are only there to decode the others.
TEST_F(IoTest, VideoThatWasCutWithoutLossIsWhole) {
  const auto source = open_input(std::string(HANDYAR_TEST_DATA_DIR) + "/cut.mp4");
  EXPECT_EQ(source->info().frame_count, 60);
  EXPECT_EQ(times_of(*source).size(), 27u);
}

TEST_F(IoTest, VideoThatBreaksOffGivesItsFramesAndSaysHowMany) {
  for (const char* ending : {".avi", ".mkv"}) {
    const std::string name = path(std::string("v") + ending);
    write_video(name, 50);
    fs::resize_file(name, fs::file_size(name) / 2);
    const auto source = open_input(name);
    Frame frame;
    int count = 0;
    const std::string fault = fault_of([&] {
      while (source->read(frame)) ++count;
    });
    EXPECT_GT(count, 5) << ending;
    EXPECT_LT(count, 45) << ending;
    EXPECT_EQ(fault.rfind(name + ": breaks off: " + std::to_string(count) + " of 5", 0), 0u)
        << fault;
  }
  const std::string sample = path("sample.mp4");
  fs::copy_file(data_file("sample/video.mp4"), sample);
  fs::resize_file(sample, fs::file_size(sample) / 3);
  const auto source = open_input(sample);
  Frame frame;
  int count = 0;
  const std::string fault = fault_of([&] {
    while (source->read(frame)) ++count;
  });
  EXPECT_GT(count, 30);
  EXPECT_EQ(fault,
            sample + ": breaks off: " + std::to_string(count) + " of 200 frames could be read");
}

// Zeros in the middle of what was written.
void damage(const std::string& path) {
  std::string bytes = read_text(path);
  std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() * 45 / 100),
              bytes.size() / 10, '\0');
  write_text(path, bytes);
}

TEST_P(VideoTest, DamagedVideoGivesItsSoundFramesAndSaysHowMany) {
  const std::string name = path(std::string("v") + GetParam());
  write_video(name, 60);
  damage(name);
  const auto source = open_input(name);
  int count = 0;
  const std::string fault = fault_of([&] {
    for (Frame frame; source->read(frame);) ++count;
  });
  EXPECT_GE(count, 5);
  EXPECT_LT(count, 60);
  EXPECT_EQ(fault.rfind(name + ": is damaged: " + std::to_string(count) + " of 6", 0), 0u) << fault;
}

// The decoder conceals what it cannot decode, and the container still has every frame.
TEST_F(IoTest, DamageThatTheDecoderConcealsIsSaid) {
  std::ostringstream stream;
  stream << std::ifstream(data_file("sample/video.mp4"), std::ios::binary).rdbuf();
  const std::string whole = stream.str();
  const auto write = [&](const std::string& bytes) {
    std::ofstream(path("v.mp4"), std::ios::binary) << bytes;
  };
  int said = 0;
  for (const std::size_t percent : {15, 25, 35, 45, 55, 65, 75, 85}) {
    std::string bytes = whole;
    for (std::size_t i = 0; i < 4; ++i) bytes[bytes.size() * percent / 100 + i] ^= '\x5a';
    write(bytes);
    const auto source = open_input(path("v.mp4"));
    const std::string fault = fault_of([&] {
      for (Frame frame; source->read(frame);) continue;
    });
    said += fault.find("is damaged") != std::string::npos;
  }
  EXPECT_GE(said, 5) << "four bytes may change a picture without a fault of its code";
  write(whole);
  EXPECT_EQ(times_of(*open_input(path("v.mp4"))).size(), 200u);
}

TEST_F(IoTest, DamageAtTheEndOfAMatroskaIsSaid) {
  write_video(path("v.mkv"), 60);
  std::string bytes = read_text(path("v.mkv"));
  const std::size_t cues = bytes.rfind("\x1c\x53\xbb\x6b");
  ASSERT_NE(cues, std::string::npos);
  std::fill_n(bytes.begin() + std::ptrdiff_t(cues) - 500, 300, '\0');
  write_text(path("v.mkv"), bytes);
  const auto source = open_input(path("v.mkv"));
  EXPECT_NE(fault_of([&] {
              for (Frame frame; source->read(frame);) continue;
            }).find("is damaged"),
            std::string::npos);
}

TEST_F(IoTest, PicturesAreReadInTheOrderOfTheirNumbers) {
  for (const int number : {8, 9, 10, 12}) {
    cv::imwrite(path("p" + std::to_string(number) + ".png"),
                cv::Mat(120, 160, CV_8UC3, cv::Scalar::all(10 * number)));
  }
  const auto source = open_input(path("p%d.png"));
  EXPECT_EQ(source->info().frame_count, 4);
  Frame frame;
  for (const int number : {8, 9, 10, 12}) {
    ASSERT_TRUE(source->read(frame));
    EXPECT_EQ(frame.index, number - 8);
    EXPECT_NEAR(frame.time_s, (number - 8) / 30.0, 1e-12);
    EXPECT_EQ(frame.bgr.at<cv::Vec3b>(0, 0)[0], 10 * number);
  }
  EXPECT_FALSE(source->read(frame));
  EXPECT_EQ(fault_of([&] { open_input(path("p%03d.png")); }),
            path("p%03d.png") + ": no picture has such a name");

  cv::imwrite(path("p13.png"), cv::Mat(130, 160, CV_8UC3, cv::Scalar::all(0)));
  const auto changing = open_input(path("p%d.png"));
  EXPECT_EQ(fault_of([&] { times_of(*changing); }),
            path("p%d.png") + ": frame 5 has 160x130 pixels, those before it 160x120");
}

TEST_F(IoTest, ASinglePictureIsHeld) {
  cv::imwrite(path("p.png"), quarters(320, 240));
  const auto source = open_input(path("p.png"));
  const std::vector<double> times_s = times_of(*source);
  ASSERT_EQ(times_s.size(), 30u);
  EXPECT_NEAR(times_s.back(), 29 / 30.0, 1e-12);
}

TEST_F(IoTest, PhotographsThatAreTooLargeAreReduced) {
  cv::imwrite(path("p1.jpg"), quarters(4032, 3024));
  cv::imwrite(path("p2.jpg"), quarters(4032, 3024));
  const auto source = open_input(path("p%d.jpg"));
  EXPECT_EQ(source->info().width_px, 2016);
  EXPECT_EQ(source->info().height_px, 1512);
  EXPECT_EQ(source->info().reduced_by, 2);
  int count = 0;
  for (Frame frame; source->read(frame); ++count) {
    EXPECT_EQ(frame.bgr.size(), cv::Size(2016, 1512));
    EXPECT_EQ(colors(frame.bgr), "RGBW");
  }
  EXPECT_EQ(count, 2);
  cv::imwrite(path("tall.jpg"), quarters(2161, 6001));
  EXPECT_EQ(open_input(path("tall.jpg"))->info().height_px, 3000);
  cv::imwrite(path("large.png"), quarters(2160, 4096));
  EXPECT_EQ(open_input(path("large.png"))->info().reduced_by, 1);
  cv::imwrite(path("wide.png"), quarters(5000, 130));
  EXPECT_EQ(fault_of([&] { open_input(path("wide.png")); }),
            path("wide.png") +
                ": 2500x65 pixels with its sides divided by 2: 160x120 to 4096x2160 are taken");
}

TEST_F(IoTest, PictureThatBreaksOffIsNone) {
  for (const char* name : {"p.jpg", "p.png"}) {
    cv::imwrite(path(name), quarters(320, 240));
    const std::string whole = read_text(path(name));
    EXPECT_NO_THROW(open_input(path(name)));
    write_text(path(name), whole + "what a camera adds");
    EXPECT_NO_THROW(open_input(path(name)));
    write_text(path(name), whole.substr(0, whole.size() * 2 / 3));
    EXPECT_EQ(fault_of([&] { open_input(path(name)); }).rfind(path(name), 0), 0u) << name;
  }
}

TEST_F(IoTest, InputsThatAreNoneAreNamed) {
  write_text(path("text.mp4"), "a text, not a video\n");
  write_text(path("text.txt"), std::string(2000, 'x'));
  write_text(path("empty.mp4"), "");
  write_text(path("noise.mp4"), std::string(3000, '\x03'));
  write_text(path("broken.png"), std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16));
  cv::imwrite(path("one.png"), cv::Mat(1, 1, CV_8UC3, cv::Scalar::all(0)));
  const auto fault = [&](const std::string& name) {
    return fault_of([&] { open_input(path(name)); });
  };
  EXPECT_EQ(fault("text.mp4"), path("text.mp4: is a text file, not a video"));
  EXPECT_EQ(fault("text.txt"), path("text.txt: is a text file, not a video"));
  EXPECT_EQ(fault("empty.mp4"), path("empty.mp4: is empty"));
  EXPECT_EQ(fault("noise.mp4"), path("noise.mp4: is not a video that can be read"));
  EXPECT_EQ(fault("broken.png"), path("broken.png: is not a picture that can be read"));
  EXPECT_EQ(fault("one.png").rfind(path("one.png: 1x1 pixels: "), 0), 0u);
  EXPECT_EQ(fault("no.mp4"), path("no.mp4: no such file, and no camera has that name"));
  EXPECT_EQ(fault("").rfind(path(""), 0), 0u);
  ::mkfifo(path("pipe.mp4").c_str(), 0600);
  EXPECT_EQ(fault("pipe.mp4"), path("pipe.mp4: is a pipe: a video or picture must be a file"));
  EXPECT_EQ(fault_of([] { open_input("/dev/zero"); }),
            "/dev/zero: is not a camera, or another program uses it");
  EXPECT_NE(fault_of([] { open_input("/dev/video987"); }), "");
  EXPECT_NE(fault_of([] { open_input("987"); }), "");
  EXPECT_NE(fault_of([] { open_input(""); }), "");
}

TEST(LatestFrameTest, SlowReaderGetsTheNewestFrame) {
  std::atomic<int> wanted{1}, given{0};
  LatestFrame latest([&](Frame& frame) {
    while (given == wanted) std::this_thread::yield();
    if (wanted < 0) return false;
    frame.time_s = ++given;
    return true;
  });
  Frame frame;
  ASSERT_TRUE(latest.read(frame));
  EXPECT_EQ(frame.time_s, 1);
  wanted = 11;
  // When the eleventh was asked for, the tenth has been handed in.
  while (given < 11) std::this_thread::yield();
  ASSERT_TRUE(latest.read(frame));
  EXPECT_GE(frame.time_s, 10);
  EXPECT_EQ(frame.index, static_cast<std::int64_t>(frame.time_s) - 1);
  wanted = -1;
  while (latest.read(frame)) {
  }
  EXPECT_EQ(frame.index, 10);
}

TEST(LatestFrameTest, FaultOfTheCameraReachesTheReader) {
  LatestFrame latest([](Frame&) -> bool { throw Error("/dev/video0", "unplugged"); });
  Frame frame;
  EXPECT_EQ(fault_of([&] { latest.read(frame); }), "/dev/video0: unplugged");
}

TEST(CamerasTest, EachHasANameOrAFault) {
  for (const CameraInfo& camera : list_cameras()) {
    EXPECT_TRUE(camera.path.starts_with("/dev/video"));
    EXPECT_FALSE(camera.name.empty() && camera.fault.empty());
  }
}

}  // namespace
}  // namespace handyar::io
