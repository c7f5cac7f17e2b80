// SPDX-License-Identifier: MIT
// Cameras, by a driver that is none.
#include "fake_driver.hpp"
#include "handyar/io/picture_file.hpp"
#include "sources.hpp"
#include "v4l2_camera.hpp"

namespace handyar::io {
namespace {

// BT.601 as video has it.
struct Yuv {
  std::uint8_t y, u, v;
};
Yuv yuv(const cv::Vec3b& bgr) {
  const double b = bgr[0], g = bgr[1], r = bgr[2];
  const auto byte = [](double x) { return static_cast<std::uint8_t>(std::lround(x)); };
  return {byte(16 + (65.481 * r + 128.553 * g + 24.966 * b) / 255),
          byte(128 + (-37.797 * r - 74.203 * g + 112 * b) / 255),
          byte(128 + (112 * r - 93.786 * g - 18.214 * b) / 255)};
}

// The quarters as a driver would lay them down.
Bytes raw(std::uint32_t fourcc, unsigned padding_bytes) {
  const cv::Mat picture = quarters(kWidth_px, kHeight_px);
  const auto at = [&](int x, int y) { return picture.at<cv::Vec3b>(y, x); };
  Bytes bytes;
  const auto rows = [&](int step, unsigned padding, auto put) {
    for (int y = 0; y < kHeight_px; y += step) {
      for (int x = 0; x < kWidth_px; x += step) put(x, y);
      bytes.insert(bytes.end(), padding, 99);
    }
  };
  const auto add = [&](std::initializer_list<std::uint8_t> more) {
    bytes.insert(bytes.end(), more);
  };
  const auto colour = [&](int x, int y) { return yuv(at(x, y)); };
  const auto luma = [&](int x, int y) { add({colour(x, y).y}); };
  switch (fourcc) {
    case V4L2_PIX_FMT_YUYV:
      rows(1, padding_bytes, [&](int x, int y) {
        add({colour(x, y).y, x % 2 == 0 ? colour(x, y).u : colour(x, y).v});
      });
      break;
    case V4L2_PIX_FMT_UYVY:
      rows(1, padding_bytes, [&](int x, int y) {
        add({x % 2 == 0 ? colour(x, y).u : colour(x, y).v, colour(x, y).y});
      });
      break;
    case V4L2_PIX_FMT_NV12:
      rows(1, padding_bytes, luma);
      rows(2, padding_bytes, [&](int x, int y) { add({colour(x, y).u, colour(x, y).v}); });
      break;
    case V4L2_PIX_FMT_YUV420:
      rows(1, padding_bytes, luma);
      rows(2, padding_bytes / 2, [&](int x, int y) { add({colour(x, y).u}); });
      rows(2, padding_bytes / 2, [&](int x, int y) { add({colour(x, y).v}); });
      break;
    case V4L2_PIX_FMT_BGR24:
      rows(1, padding_bytes, [&](int x, int y) { add({at(x, y)[0], at(x, y)[1], at(x, y)[2]}); });
      break;
    case V4L2_PIX_FMT_RGB24:
      rows(1, padding_bytes, [&](int x, int y) { add({at(x, y)[2], at(x, y)[1], at(x, y)[0]}); });
      break;
    default:
      ADD_FAILURE() << fourcc;
  }
  return bytes;
}

Bytes jpeg(const cv::Scalar& bgr) {
  return encode_picture(cv::Mat(kHeight_px, kWidth_px, CV_8UC3, bgr), ".jpg", "");
}

// Whose every part has much to tell.
Bytes jpeg_of_noise() {
  cv::Mat noise(kHeight_px, kWidth_px, CV_8UC3);
  cv::RNG(3).fill(noise, cv::RNG::UNIFORM, 0, 256);
  return encode_picture(noise, ".jpg", "", 60);
}

TEST(LiveSourceTest, RawPixelsAreReadWithTheirTimes) {
  for (const std::uint32_t fourcc : {V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_UYVY, V4L2_PIX_FMT_NV12,
                                     V4L2_PIX_FMT_YUV420, V4L2_PIX_FMT_BGR24, V4L2_PIX_FMT_RGB24}) {
    for (const unsigned padding_bytes : {0u, 64u}) {
      FakeDriver driver;
      driver.formats = {V4L2_PIX_FMT_GREY, fourcc};
      driver.padding_bytes = padding_bytes;
      driver.buffer_bytes = raw(fourcc, padding_bytes).size();
      for (const double taken_s : {kStart_s, kStart_s + 0.04})
        driver.shots.push_back({raw(fourcc, padding_bytes), taken_s});
      V4l2Camera camera(kDevice, {}, driver);
      EXPECT_EQ(driver.chosen, fourcc);
      for (const double taken_s : {kStart_s, kStart_s + 0.04}) {
        cv::Mat bgr;
        double seen_s = 0;
        ASSERT_TRUE(camera.read(bgr, seen_s));
        EXPECT_NEAR(seen_s, taken_s, 1e-6);
        const cv::Mat wanted = quarters(kWidth_px, kHeight_px);
        ASSERT_EQ(bgr.size(), wanted.size());
        for (const cv::Point at : {cv::Point(9, 9), {300, 9}, {9, 200}, {319, 239}})
          EXPECT_LE(cv::norm(bgr.at<cv::Vec3b>(at), wanted.at<cv::Vec3b>(at), cv::NORM_INF), 4)
              << fourcc << " " << padding_bytes << " " << at;
      }
    }
  }
}

TEST(LiveSourceTest, JpegsThatAreNotSoundAreLeftOut) {
  FakeDriver driver;
  driver.formats = {V4L2_PIX_FMT_MJPEG};
  Bytes whole = jpeg_of_noise(), zeros = whole;
  const Bytes cut(whole.begin(), whole.begin() + std::ssize(whole) / 2);
  std::fill_n(zeros.begin() + std::ssize(zeros) / 2, std::ssize(zeros) / 4, std::uint8_t{0});
  driver.shots = {{cut, 1},   {jpeg({255, 0, 0}), 2}, {zeros, 3},
                  {{}, 4},    {jpeg({0, 0, 255}), 5}, {jpeg({0, 255, 0}), 6, true},
                  {whole, 7}, {Bytes(500, 0xff), 8}};
  V4l2Camera camera(kDevice, {}, driver);
  std::vector<double> times_s;
  std::vector<cv::Vec3b> middles;
  cv::Mat bgr;
  for (double taken_s = 0; camera.read(bgr, taken_s);) {
    times_s.push_back(taken_s);
    middles.push_back(bgr.at<cv::Vec3b>(100, 100));
    EXPECT_EQ(bgr.size(), cv::Size(kWidth_px, kHeight_px));
  }
  ASSERT_EQ(times_s, (std::vector<double>{2, 5, 7}));
  EXPECT_LE(cv::norm(middles[0], cv::Vec3b(255, 0, 0), cv::NORM_INF), 4);
  EXPECT_LE(cv::norm(middles[1], cv::Vec3b(0, 0, 255), cv::NORM_INF), 4);
}

TEST(LiveSourceTest, PicturesThatAreTooShortAreLeftOut) {
  FakeDriver driver;
  Bytes whole = raw(V4L2_PIX_FMT_YUYV, 0);
  const Bytes cut(whole.begin(), whole.end() - 1);
  driver.shots = {{cut, 1}, {whole, 2}};
  V4l2Camera camera(kDevice, {}, driver);
  cv::Mat bgr;
  double taken_s = 0;
  ASSERT_TRUE(camera.read(bgr, taken_s));
  EXPECT_EQ(taken_s, 2);
  EXPECT_FALSE(camera.read(bgr, taken_s));

  FakeDriver other;
  other.padding_bytes = 0x66666680 - 2 * kWidth_px;  // a row of these, times 640: 16384 in 32 bit
  other.shots = {{whole, 3}};
  EXPECT_FALSE(V4l2Camera(kDevice, {}, other).read(bgr, taken_s));
}

// The message with which a source ends.
std::string end_of(FrameSource& source) {
  return fault_of([&] {
    for (Frame frame; source.read(frame);) EXPECT_EQ(colors(frame.bgr), "RGBW");
  });
}

TEST(LiveSourceTest, CameraThatStopsOrIsUnpluggedIsSaid) {
  for (const bool stalls : {false, true}) {
    FakeDriver driver;
    driver.stalls = stalls;
    EXPECT_EQ(fault_of([&] { open_camera(kDevice, {}, driver); }),
              "/dev/video0: the camera gives no pictures");
    for (int i = 0; i < 5; ++i)
      driver.shots.push_back({raw(V4L2_PIX_FMT_YUYV, 0), kStart_s + i / 30.0});
    EXPECT_EQ(end_of(*open_camera(kDevice, {}, driver)),
              "/dev/video0: the camera gives no more pictures");
    EXPECT_EQ(driver.open_devices, 0);
    EXPECT_EQ(driver.mapped, 0);
  }
}

TEST(LiveSourceTest, WaitForAStalledCameraCanBeEnded) {
  FakeDriver driver;
  driver.stalls = true;
  driver.pause_ms = 20;
  driver.shots = {{raw(V4L2_PIX_FMT_YUYV, 0)}, {raw(V4L2_PIX_FMT_YUYV, 0), kStart_s + 1}};
  {
    const auto source = open_camera(kDevice, {}, driver);
    int asked = 0;
    source->ask_while_waiting([&] { return ++asked < 3; });
    Frame frame;
    EXPECT_TRUE(source->read(frame));
    EXPECT_FALSE(source->read(frame));
    EXPECT_EQ(asked, 3);
  }
  EXPECT_LT(driver.polls, 90);  // it would be given up after a hundred
  EXPECT_EQ(driver.open_devices, 0);
  EXPECT_EQ(driver.mapped, 0);
}

TEST(LiveSourceTest, WhatIsNoCameraIsSaid) {
  const auto fault = [](auto change) {
    FakeDriver driver;
    driver.shots = {{raw(V4L2_PIX_FMT_YUYV, 0)}};
    change(driver);
    const std::string said = fault_of([&] { open_camera(kDevice, {}, driver); });
    EXPECT_EQ(driver.open_devices, 0);
    EXPECT_EQ(driver.mapped, 0);
    return said;
  };
  const std::string none = "/dev/video0: is not a camera, or another program uses it";
  EXPECT_EQ(fault([](FakeDriver&) {}), "");
  EXPECT_EQ(fault([](FakeDriver& driver) { driver.is_camera = false; }), none);
  EXPECT_EQ(fault([](FakeDriver& driver) { driver.busy = true; }), none);
  EXPECT_EQ(fault([](FakeDriver& driver) { driver.formats = {V4L2_PIX_FMT_H264}; }), none);
  for (const unsigned width_px : {0u, 1u << 30})
    EXPECT_EQ(fault([=](FakeDriver& driver) { driver.width_px = width_px; }), none) << width_px;
  FakeDriver driver;
  EXPECT_EQ(fault_of([&] { open_camera("/dev/video1", {}, driver); }),
            "/dev/video1: no such camera, or it cannot be opened: No such file or directory");
}

TEST(LiveSourceTest, SizeAndRateAreAskedFor) {
  FakeDriver driver;
  driver.formats = {V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_MJPEG};
  driver.shots = {{raw(V4L2_PIX_FMT_YUYV, 0)}};
  CameraSettings settings;
  settings.width_px = kWidth_px;
  settings.height_px = kHeight_px;
  settings.fps = 15;
  const auto source = open_camera(kDevice, settings, driver);
  EXPECT_EQ(driver.chosen, V4L2_PIX_FMT_YUYV);
  EXPECT_NEAR(driver.rate, 15, 1e-6);
  EXPECT_NEAR(source->info().fps, 15, 1e-6);
  EXPECT_TRUE(source->info().live);
  EXPECT_EQ(source->info().width_px, kWidth_px);

  FakeDriver other;
  other.formats = driver.formats;
  other.shots = {{jpeg({0, 0, 255})}};
  settings.width_px = 1280;
  settings.height_px = 720;
  EXPECT_EQ(fault_of([&] { open_camera(kDevice, settings, other); }),
            "/dev/video0: gives no pictures of 1280x720, but of 320x240 pixels");
  EXPECT_EQ(other.chosen, V4L2_PIX_FMT_MJPEG) << "large pictures come compressed";
}

TEST(LiveSourceTest, ExposureAndColoursAreLockedAfterASecond) {
  for (const bool lock : {false, true}) {
    FakeDriver driver;
    driver.pause_ms = 20;
    for (int i = 0; i < 8; ++i)
      driver.shots.push_back({raw(V4L2_PIX_FMT_YUYV, 0), kStart_s + 0.2 * i});
    CameraSettings settings;
    settings.lock = lock;
    EXPECT_NE(end_of(*open_camera(kDevice, settings, driver)), "");
    EXPECT_EQ(driver.controls.size(), lock ? 3u : 0u);
    if (!lock) continue;
    EXPECT_EQ(driver.controls[V4L2_CID_EXPOSURE_AUTO], V4L2_EXPOSURE_MANUAL);
    EXPECT_EQ(driver.controls[V4L2_CID_AUTO_WHITE_BALANCE], 0);
    EXPECT_EQ(driver.controls[V4L2_CID_FOCUS_AUTO], 0);
  }
}

}  // namespace
}  // namespace handyar::io
