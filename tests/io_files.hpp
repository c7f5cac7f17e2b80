// SPDX-License-Identifier: MIT
// What tests of handyar::io read and write.
#pragma once

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "handyar/io/error.hpp"
#include "handyar/io/frame_source.hpp"
#include "handyar/io/video_writer.hpp"
#include "temporary_folder.hpp"

namespace handyar::io {

namespace fs = std::filesystem;

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

inline std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const auto at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return at == std::string::npos ? text : text.replace(at, what.size(), by);
}

// Memory behind which there is none: who reads on there is killed.
class Guarded {
 public:
  explicit Guarded(std::size_t bytes) {
    const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
    const std::size_t before = (bytes + page - 1) / page * page;
    size_ = before + page;
    begin_ = static_cast<std::uint8_t*>(
        ::mmap(nullptr, size_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
    ::mprotect(begin_ + before, page, PROT_NONE);
    data_ = begin_ + before - bytes;
  }
  ~Guarded() { ::munmap(begin_, size_); }
  Guarded(const Guarded&) = delete;
  Guarded& operator=(const Guarded&) = delete;

  std::uint8_t* data() const { return data_; }

 private:
  std::uint8_t *begin_, *data_;
  std::size_t size_;
};

// Red, green, blue and white quarters, so that every turn of the picture shows.
inline cv::Mat quarters(int width, int height) {
  cv::Mat picture(height, width, CV_8UC3, cv::Scalar(255, 255, 255));
  picture(cv::Rect(0, 0, width / 2, height / 2)).setTo(cv::Scalar(0, 0, 255));
  picture(cv::Rect(width / 2, 0, width / 2, height / 2)).setTo(cv::Scalar(0, 255, 0));
  picture(cv::Rect(0, height / 2, width / 2, height / 2)).setTo(cv::Scalar(255, 0, 0));
  return picture;
}

// The quarters' colours, row by row: "RGBW" when upright.
inline std::string colors(const cv::Mat& picture) {
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

inline void write_video(const std::string& path, int frames) {
  VideoWriter writer(path, 160, 120, 25);
  for (int i = 0; i < frames; ++i) {
    cv::Mat picture = quarters(160, 120);
    cv::circle(picture, {20 + 3 * i, 60}, 10, {0, 0, 0}, cv::FILLED);
    writer.write(picture, i / 25.0);
  }
  writer.finish();
}

inline std::vector<double> times_of(FrameSource& source) {
  std::vector<double> times;
  for (Frame frame; source.read(frame);) times.push_back(frame.time_s);
  return times;
}

}  // namespace handyar::io
