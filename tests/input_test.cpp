// SPDX-License-Identifier: MIT
// Pictures, cameras, and inputs that are none.
#include <atomic>
#include <opencv2/imgcodecs.hpp>
#include <thread>

#include "handyar/io/cameras.hpp"
#include "handyar/io/latest_frame.hpp"
#include "handyar/io/pending_file.hpp"
#include "handyar/io/sample.hpp"
#include "io_files.hpp"

namespace handyar::io {
namespace {

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
  cv::imwrite(path("line.png"), quarters(20000, 2));
  EXPECT_EQ(fault_of([&] { open_input(path("line.png")); }),
            path("line.png") +
                ": 10000x1 pixels with its sides divided by 2: 160x120 to 4096x2160 are taken");
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
  for (const char* name : {"*.png", "%4d.png", "p?.png"})
    EXPECT_EQ(fault(name), path(name) +
                               ": no such file; for a series of pictures give a pattern, "
                               "such as " +
                               path("%04d.png"));
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
  LatestFrame latest([&](Frame& frame, const std::stop_token&) {
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
  LatestFrame latest(
      [](Frame&, const std::stop_token&) -> bool { throw Error("/dev/video0", "unplugged"); });
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
