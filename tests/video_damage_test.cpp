// SPDX-License-Identifier: MIT
// Videos that break off or are damaged: what is sound of them is read, and the fault is said.
#include <algorithm>
#include <fstream>
#include <sstream>

#include "handyar/io/pending_file.hpp"
#include "handyar/io/sample.hpp"
#include "io_files.hpp"

namespace handyar::io {
namespace {

// How many frames a source gives until its fault, and that.
struct Read {
  int count = 0;
  std::string fault;
};
Read read_all(FrameSource& source) {
  Read read;
  read.fault = fault_of([&] {
    for (Frame frame; source.read(frame);) ++read.count;
  });
  return read;
}

TEST_F(IoTest, VideoThatBreaksOffGivesItsFramesAndSaysHowMany) {
  for (const char* ending : {".avi", ".mkv"}) {
    const std::string name = path(std::string("v") + ending);
    write_video(name, 50);
    fs::resize_file(name, fs::file_size(name) / 2);
    const auto [count, fault] = read_all(*open_input(name));
    EXPECT_GT(count, 5) << ending;
    EXPECT_LT(count, 45) << ending;
    EXPECT_EQ(fault.rfind(name + ": breaks off: " + std::to_string(count) + " of 5", 0), 0u)
        << fault;
  }
  const std::string sample = path("sample.mp4");
  fs::copy_file(data_file("sample/video.mp4"), sample);
  fs::resize_file(sample, fs::file_size(sample) / 3);
  const auto [count, fault] = read_all(*open_input(sample));
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

class DamagedVideoTest : public IoTest, public testing::WithParamInterface<const char*> {};

TEST_P(DamagedVideoTest, GivesItsSoundFramesAndSaysHowMany) {
  const std::string name = path(std::string("v") + GetParam());
  write_video(name, 60);
  damage(name);
  const auto [count, fault] = read_all(*open_input(name));
  EXPECT_GE(count, 5);
  EXPECT_LT(count, 60);
  EXPECT_EQ(fault.rfind(name + ": is damaged: " + std::to_string(count) + " of 6", 0), 0u) << fault;
}
INSTANTIATE_TEST_SUITE_P(Containers, DamagedVideoTest,
                         testing::Values(".mp4", ".mkv", ".avi", ".mov"),
                         [](const auto& param) { return std::string(param.param + 1); });

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

}  // namespace
}  // namespace handyar::io
