// SPDX-License-Identifier: MIT
// Signals that end the program.
#include <fcntl.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <set>
#include <thread>
#include <vector>

#include "command_line.hpp"

namespace handyar {
namespace {

// The program in a process of its own, silent.
pid_t started(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "handyar");
  const pid_t child = ::fork();
  if (child != 0) return child;
  std::freopen("/dev/null", "w", stdout);
  std::freopen("/dev/null", "w", stderr);
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  ::execv(HANDYAR_PROGRAM, argv.data());
  ::_exit(99);
}

// How it ended; it is killed after ten seconds.
int ended(pid_t child) {
  int status = 0;
  for (int i = 0; ::waitpid(child, &status, WNOHANG) == 0; ++i) {
    if (i == 1000) ::kill(child, SIGKILL);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return status;
}

TEST_F(CliTest, InterruptFinishesTheFiles) {
  for (const int signals : {1, 2}) {  // as one wish: a second later the second one would kill
    const pid_t child = started(
        {"track", kData + "/sample/video.mp4", "--poses", out("p.csv"), "--video", out("v.mp4")});
    // Interrupts are caught before the first output file is there.
    while (left().empty()) std::this_thread::yield();
    for (int i = 0; i < signals; ++i) {
      ::kill(child, SIGINT);
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    const int status = ended(child);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return;  // done before the signal came
    ASSERT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 130);
    EXPECT_EQ(left(), (std::set<std::string>{"p.csv", "v.mp4"}));
    const std::string poses = contents(out("p.csv"));
    EXPECT_EQ(poses.back(), '\n');
    EXPECT_LT(lines(poses), 201);
    fs::remove(out("p.csv"));
    fs::remove(out("v.mp4"));
  }
}

TEST_F(CliTest, ASecondInterruptKillsWhatDoesNotEnd) {
  ASSERT_EQ(::mkfifo(out("p.csv").c_str(), 0600), 0);
  const pid_t child = started({"track", "sample", "--poses", out("p.csv")});
  const int reader = ::open(out("p.csv").c_str(), O_RDONLY | O_CLOEXEC);
  ASSERT_GE(reader, 0);
  const int room = ::fcntl(reader, F_SETPIPE_SZ, 4096);  // full soon, for nobody reads
  for (int held = 0, i = 0; held < room && i < 1000; ++i) {
    ::ioctl(reader, FIONREAD, &held);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  ::kill(child, SIGTERM);
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  EXPECT_EQ(::waitpid(child, nullptr, WNOHANG), 0) << "it still waits";
  ::kill(child, SIGTERM);
  const int status = ended(child);
  ::close(reader);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(WTERMSIG(status), SIGTERM);
}

TEST_F(CliTest, OneInterruptEndsTheWaitForThePipesReader) {
  ASSERT_EQ(::mkfifo(out("p.csv").c_str(), 0600), 0);
  ASSERT_EQ(::mkfifo(out("b.pdf").c_str(), 0600), 0);
  const std::vector<std::string> commands[] = {{"track", kVideo, "--poses", out("p.csv")},
                                               {"board", "--out", out("b.pdf")}};
  for (const auto& command : commands) {
    const pid_t child = started(command);
    std::this_thread::sleep_for(std::chrono::seconds(1));
    ::kill(child, SIGTERM);
    const int status = ended(child);
    ASSERT_TRUE(WIFEXITED(status)) << command[0];
    EXPECT_EQ(WEXITSTATUS(status), 128 + SIGTERM) << command[0];
  }
}

}  // namespace
}  // namespace handyar
