// SPDX-License-Identifier: MIT
// Videos are read back as they were written, and others as they are.
#include <sys/resource.h>

#include <csignal>
#include <cstdint>
#include <opencv2/core.hpp>

#include "handyar/io/recording.hpp"
#include "io_files.hpp"

namespace handyar::io {
namespace {

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

// What ffmpeg's own turning makes of the same files; each was made from the same upright-looking
// stream by setting the container's rotation.
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

}  // namespace
}  // namespace handyar::io
