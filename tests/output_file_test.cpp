// SPDX-License-Identifier: MIT
// Files in the making: they are whole or not there, and where they cannot be written it is said.
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <clocale>
#include <csignal>
#include <future>
#include <optional>

#include "handyar/io/pending_file.hpp"
#include "handyar/io/pose_csv.hpp"
#include "io_files.hpp"

namespace handyar::io {
namespace {

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

TEST_F(IoTest, AWriteProtectedFileStays) {
  write_text(path("p.csv"), "old");
  fs::permissions(path("p.csv"), fs::perms::owner_read | fs::perms::others_read);
  fs::permissions(folder_, fs::perms::all);
  const pid_t child = ::fork();
  if (child == 0) {
    if (::getuid() == 0 && ::setuid(65534) != 0) ::_exit(2);  // root may write it all the same
    const std::string fault = fault_of([&] { write_text(path("p.csv"), "new"); });
    ::_exit(fault == path("p.csv: cannot be written: Permission denied") ? 0 : 1);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_EQ(read_text(path("p.csv")), "old");
  EXPECT_EQ(files(), 1u);
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

}  // namespace
}  // namespace handyar::io
