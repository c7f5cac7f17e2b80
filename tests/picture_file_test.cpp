// SPDX-License-Identifier: MIT
// Pictures are read as OpenCV reads them, and written so that it reads them.
#include "handyar/io/picture_file.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "handyar/io/pending_file.hpp"
#include "io_files.hpp"

namespace handyar::io {
namespace {

using Bytes = std::vector<std::uint8_t>;
using Pixels = PictureOptions::Pixels;

// Smooth, and of all colours; with an odd width, whose last column has its colours alone.
cv::Mat smooth(int type = CV_8UC3) {
  cv::Mat small(5, 7, CV_8UC3), picture;
  cv::RNG(5).fill(small, cv::RNG::UNIFORM, 20, 220);
  cv::resize(small, picture, {301, 203}, 0, 0, cv::INTER_CUBIC);
  cv::Mat grey;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  if (CV_MAT_CN(type) == 1) picture = grey;
  if (CV_MAT_CN(type) == 4) cv::merge(std::vector<cv::Mat>{picture, grey}, picture);
  if (CV_MAT_DEPTH(type) == CV_16U) picture.convertTo(picture, CV_16U, 257);
  return picture;
}

// Mean of the differences and of their amounts, in grey values.
struct Difference {
  double bias, amount;
};
Difference difference(const cv::Mat& a, const cv::Mat& b) {
  EXPECT_EQ(a.size(), b.size());
  EXPECT_EQ(a.type(), b.type());
  if (a.size() != b.size() || a.type() != b.type()) return {1e9, 1e9};
  cv::Mat d;
  cv::subtract(a.reshape(1), b.reshape(1), d, cv::noArray(), CV_32F);
  return {cv::mean(d)[0], cv::norm(d, cv::NORM_L1) / static_cast<double>(d.total())};
}

TEST_F(IoTest, PicturesAreReadAsOpenCvReadsThem) {
  const struct {
    const char* name;
    int type;
    double most;  ///< how far from OpenCV's, in the mean
  } files[] = {
      {"colour.png", CV_8UC3, 0},    {"grey.png", CV_8UC1, 0},     {"colour16.png", CV_16UC3, 0.1},
      {"grey16.png", CV_16UC1, 0.1}, {"alpha.png", CV_8UC4, 0},    {"colour.bmp", CV_8UC3, 0},
      {"colour.ppm", CV_8UC3, 0},    {"grey.pgm", CV_8UC1, 0},     {"colour.tif", CV_8UC3, 0},
      {"colour16.tif", CV_16UC3, 0}, {"grey.tif", CV_8UC1, 0},     {"colour.jp2", CV_8UC3, 1},
      {"grey.jpg", CV_8UC1, 0.1},    {"colour.jpg", CV_8UC3, 1.2}, {"colour.webp", CV_8UC3, 1.2},
  };
  for (const auto& [name, type, most] : files) {
    ASSERT_TRUE(cv::imwrite(path(name), smooth(type))) << name;
    const Difference bgr =
        difference(read_picture(path(name)), cv::imread(path(name), cv::IMREAD_COLOR));
    EXPECT_LE(bgr.amount, most) << name;
    EXPECT_LE(std::abs(bgr.bias), 0.1) << name;
    if (CV_MAT_CN(type) == 1) {
      const cv::Mat grey = read_picture(path(name), {.pixels = Pixels::grey});
      EXPECT_LE(difference(grey, cv::imread(path(name), cv::IMREAD_GRAYSCALE)).amount, most);
    }
    cv::Mat wanted = cv::imread(path(name), cv::IMREAD_UNCHANGED);
    if (wanted.depth() == CV_16U) wanted.convertTo(wanted, CV_8U, 1.0 / 257);
    cv::cvtColor(wanted, wanted,
                 wanted.channels() == 1   ? cv::COLOR_GRAY2RGBA
                 : wanted.channels() == 3 ? cv::COLOR_BGR2RGBA
                                          : cv::COLOR_BGRA2RGBA);
    EXPECT_LE(difference(read_picture(path(name), {.pixels = Pixels::rgba}), wanted).amount, most)
        << name;
  }
}

TEST_F(IoTest, PalettesHaveColoursAndAlpha) {
  // Red, green that is not there, blue, and 10, 20, 30; then the same backwards: two bits a pixel.
  static constexpr char kPng[] =
      "\x89\x50\x4e\x47\x0d\x0a\x1a\x0a\x00\x00\x00\x0d\x49\x48\x44\x52\x00\x00\x00\x04"
      "\x00\x00\x00\x02\x02\x03\x00\x00\x00\x02\xc6\x95\xf0\x00\x00\x00\x0c\x50\x4c\x54"
      "\x45\xff\x00\x00\x00\xff\x00\x00\x00\xff\x0a\x14\x1e\x22\x88\x29\x04\x00\x00\x00"
      "\x02\x74\x52\x4e\x53\xff\x00\xe5\xb7\x30\x4a\x00\x00\x00\x0c\x49\x44\x41\x54\x78"
      "\xda\x63\x90\x66\x78\x02\x00\x01\x39\x01\x00\x7b\x99\x42\x37\x00\x00\x00\x00\x49"
      "\x45\x4e\x44\xae\x42\x60\x82";
  const Bytes file(std::begin(kPng), std::end(kPng) - 1);
  const cv::Mat rgba = decode_picture(file, "p.png", {.pixels = Pixels::rgba});
  ASSERT_EQ(rgba.size(), cv::Size(4, 2));
  EXPECT_EQ(rgba.at<cv::Vec4b>(0, 0), cv::Vec4b(255, 0, 0, 255));
  EXPECT_EQ(rgba.at<cv::Vec4b>(0, 1), cv::Vec4b(0, 255, 0, 0));
  EXPECT_EQ(rgba.at<cv::Vec4b>(1, 0), cv::Vec4b(10, 20, 30, 255));
  EXPECT_EQ(decode_picture(file, "p.png").at<cv::Vec3b>(1, 0), cv::Vec3b(30, 20, 10));
}

std::string number(std::size_t value, int bytes, bool little) {
  std::string text;
  for (int i = 0; i < bytes; ++i)
    text += static_cast<char>(value >> 8 * (little ? i : bytes - 1 - i));
  return text;
}

// A JPEG or PNG with what a telephone notes: how it was held.
std::string with_orientation(std::string file, int orientation, bool little) {
  const auto n = [=](std::size_t value, int bytes) { return number(value, bytes, little); };
  const std::string tiff = std::string(little ? "II" : "MM") + n(42, 2) + n(8, 4) + n(1, 2) +
                           n(0x112, 2) + n(3, 2) + n(1, 4) + n(std::size_t(orientation), 2) +
                           n(0, 2) + n(0, 4);
  constexpr std::size_t kPngHead = 8 + 25;  // with its first chunk
  if (file.starts_with("\x89PNG"))
    return file.insert(kPngHead, number(tiff.size(), 4, false) + "eXIf" + tiff + "\0\0\0\0");
  const std::string exif = std::string("Exif\0\0", 6) + tiff;
  return file.insert(2, "\xff\xe1" + number(exif.size() + 2, 2, false) + exif);
}

TEST_F(IoTest, PicturesAreTurnedAsTheirExifSays) {
  cv::imwrite(path("p.jpg"), quarters(320, 240));
  const std::string whole = read_text(path("p.jpg"));
  for (const int orientation : {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 0x105})
    for (const bool little : {false, true}) {
      write_text(path("t.jpg"), with_orientation(whole, orientation, little));
      EXPECT_LE(difference(read_picture(path("t.jpg")), cv::imread(path("t.jpg"))).amount, 1)
          << orientation;
      const cv::Mat stored = read_picture(path("t.jpg"), {.upright = false});
      EXPECT_EQ(stored.size(), cv::Size(320, 240));
      EXPECT_EQ(colors(stored), "RGBW") << orientation;
    }
}

TEST_F(IoTest, PicturesThatAreNoneAreNamed) {
  const cv::Mat picture = smooth();
  for (const char* name : {"p.png", "p.jpg", "p.bmp", "p.ppm", "p.tif", "p.webp", "p.jp2"})
    cv::imwrite(path(name), picture);
  const auto fault = [&](const std::string& name, const std::string& bytes) {
    write_text(path(name), bytes);
    testing::internal::CaptureStderr();
    std::string said = fault_of([&] { read_picture(path(name)); });
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << name;
    return said;
  };
  const std::string none = ": is not a picture that can be read";
  for (const char* name : {"p.png", "p.bmp", "p.ppm", "p.tif", "p.webp", "p.jp2"}) {
    const std::string whole = read_text(path(name));
    EXPECT_EQ(fault(name, whole.substr(0, whole.size() / 2)), path(name) + none);
    EXPECT_EQ(fault(name, whole.substr(0, 20)), path(name) + none);
  }
  std::string jpeg = read_text(path("p.jpg"));
  EXPECT_EQ(fault("p.jpg", jpeg.substr(0, jpeg.size() / 2)), path("p.jpg: breaks off"));
  std::fill_n(jpeg.begin() + std::ssize(jpeg) / 2, 200, '\0');
  EXPECT_EQ(fault("p.jpg", jpeg), path("p.jpg") + none);
  for (const char* bytes : {"", "B", "P6", "P6\n1 1\n", "RIFF", "II*", "text", "\xff\xd8\xff"})
    EXPECT_EQ(fault("n.png", bytes).rfind(path("n.png: "), 0), 0u) << bytes;
  EXPECT_EQ(fault_of([&] { read_picture(path("gone.png")); }),
            path("gone.png: cannot be read: No such file or directory"));
  ASSERT_EQ(::mkfifo(path("pipe.png").c_str(), 0600), 0);  // to open it waits for who writes
  for (const std::string& name : {folder_.string(), path("pipe.png")})
    EXPECT_EQ(fault_of([&] { read_picture(name); }), name + ": is not a file");
}

TEST_F(IoTest, PicturesOfUnreasonableSizeAreRefused) {
  std::string huge("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\xff\xff\0\0\xff\xff\x08\x02\0\0\0", 29);
  huge += std::string("\x39\x67\x4e\x07\0\0\0\0IEND\xae\x42\x60\x82", 16);
  write_text(path("h.png"), huge);
  EXPECT_EQ(fault_of([&] { read_picture(path("h.png")); }),
            path("h.png: is not a picture that can be read"));
  write_text(path("h.ppm"), "P6\n60000 60000\n255\n");
  EXPECT_EQ(fault_of([&] { read_picture(path("h.ppm")); }),
            path("h.ppm: is not a picture that can be read"));
}

TEST_F(IoTest, PicturesAreWrittenForOthersToRead) {
  for (const int type : {CV_8UC1, CV_8UC3}) {
    const cv::Mat picture = smooth(type);
    write_picture(path("p.PNG"), picture);
    EXPECT_EQ(difference(cv::imread(path("p.PNG"), cv::IMREAD_UNCHANGED), picture).amount, 0);
    write_picture(path("p.jpeg"), picture);
    const cv::Mat jpeg =
        cv::imread(path("p.jpeg"), type == CV_8UC1 ? cv::IMREAD_GRAYSCALE : cv::IMREAD_COLOR);
    EXPECT_LT(difference(jpeg, picture).amount, 2);
    EXPECT_LT(std::abs(difference(jpeg, picture).bias), 0.2);
  }
  EXPECT_EQ(files(), 2u);
  std::size_t before = 0;
  double last = 1e9;
  for (const int quality : {1, 40, 82, 95}) {
    const Bytes bytes = encode_picture(smooth(), ".jpg", "p.jpg", quality);
    const double amount = difference(cv::imdecode(bytes, cv::IMREAD_COLOR), smooth()).amount;
    EXPECT_GT(bytes.size(), before) << quality;
    EXPECT_LT(amount, last) << quality;
    before = bytes.size();
    last = amount;
  }
}

TEST_F(IoTest, NothingIsReadBehindAPicture) {
  for (int width = 160; width < 192; ++width)
    for (const int channels : {1, 3}) {
      const std::size_t bytes = 121u * static_cast<std::size_t>(width * channels);
      const Guarded memory(bytes);
      const cv::Mat picture(121, width, CV_8UC(channels), memory.data());
      for (const char* extension : {".png", ".jpg"})
        EXPECT_GT(encode_picture(picture, extension, "p").size(), 100u) << width;
    }
}

TEST_F(IoTest, WhatCannotBeWrittenAsAPictureIsRefused) {
  const auto fault = [&](const char* name, const cv::Mat& picture) {
    return fault_of([&] { write_picture(path(name), picture); });
  };
  EXPECT_EQ(fault("p.gif", smooth()), path("p.gif: its name must end in .png, .jpg or .jpeg"));
  EXPECT_EQ(fault("p", smooth()), path("p: its name must end in .png, .jpg or .jpeg"));
  EXPECT_EQ(fault("p.png", cv::Mat()), path("p.png: cannot be encoded"));
  EXPECT_EQ(fault("p.png", smooth(CV_16UC3)), path("p.png: cannot be encoded"));
  EXPECT_EQ(fault("p.png", smooth(CV_8UC4)), path("p.png: cannot be encoded"));
  EXPECT_EQ(fault("no/p.png", smooth()),
            path("no/p.png: cannot be written: No such file or directory"));
  EXPECT_EQ(files(), 0u);
}

}  // namespace
}  // namespace handyar::io
