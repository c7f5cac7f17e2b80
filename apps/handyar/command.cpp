// SPDX-License-Identifier: MIT
#include "command.hpp"

#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>

namespace handyar::cli {
namespace {

volatile std::sig_atomic_t caught_signal = 0;

void note_signal(int signal) {
  caught_signal = signal;
  std::signal(signal, SIG_DFL);
}

}  // namespace

void catch_interrupts() {
  std::signal(SIGINT, note_signal);
  std::signal(SIGTERM, note_signal);
}

int interrupt() noexcept { return caught_signal; }

double steady_now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

ProgressLine::~ProgressLine() {
  if (shown_) std::fputs("\r\033[K", stderr);
}

void ProgressLine::show(std::int64_t done, std::int64_t of, const std::string& after) {
  static const bool terminal = ::isatty(STDERR_FILENO) == 1;
  if (!terminal || steady_now_s() < next_s_) return;
  next_s_ = steady_now_s() + 0.1;
  shown_ = true;
  std::fprintf(stderr, "\r\033[K%s%lld", before_.c_str(), static_cast<long long>(done));
  if (of > 0) std::fprintf(stderr, " of %lld", static_cast<long long>(of));
  std::fputs(after.c_str(), stderr);
  std::fflush(stderr);
}

}  // namespace handyar::cli
