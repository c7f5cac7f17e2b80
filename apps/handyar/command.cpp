// SPDX-License-Identifier: MIT
#include "command.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <sstream>

#include "handyar/io/frame_source.hpp"

namespace fs = std::filesystem;

namespace handyar::cli {
namespace {

volatile std::sig_atomic_t caught_signal = 0;
volatile double caught_s = 0;

// One wish to end often comes as two signals at once: timeout sends one to the process and one to
// its group, a terminal that closes does likewise. A person takes longer to lose patience.
void note_signal(int signal) {
  constexpr double kPatience_s = 1;
  if (caught_signal == 0) {
    caught_s = steady_now_s();
    caught_signal = signal;
  } else if (steady_now_s() - caught_s > kPatience_s) {
    std::signal(signal, SIG_DFL);
    ::raise(signal);
  }
}

// `b` may be a numbered series of pictures, of which `a` is one.
bool same_file(const std::string& a, const std::string& b) {
  if (a.empty() || b.empty()) return false;
  std::error_code fault;
  if (a == b || fs::equivalent(a, b, fault)) return true;
  // Neither need be there yet.
  const fs::path whole_a = fs::weakly_canonical(fs::absolute(a), fault);
  if (fault) return false;
  const fs::path whole_b = fs::weakly_canonical(fs::absolute(b), fault);
  return whole_a == whole_b || io::is_in_series(whole_a.string(), whole_b.string());
}

}  // namespace

CLI::Validator between(double low, double high) {
  std::ostringstream range;
  range << low << " to " << high;
  const auto fault_of = [=, range = range.str()](std::string& text) {
    double value = 0;
    const bool good = CLI::detail::lexical_cast(text, value) && value >= low && value <= high;
    return good ? std::string() : text + " is not a number from " + range;
  };
  return CLI::Validator(fault_of, range.str());
}

CLI::Validator ends_in(std::vector<std::string> extensions) {
  const auto fault_of = [extensions = std::move(extensions)](const std::string& name) {
    const std::string type = CLI::detail::to_lower(fs::path(name).extension().string());
    const bool good = std::find(extensions.begin(), extensions.end(), type) != extensions.end();
    return good ? "" : name + " does not end in " + CLI::detail::join(extensions, ", ");
  };
  return CLI::Validator(fault_of, "");
}

std::string HelpFormatter::make_option_opts(const CLI::Option* option) const {
  if (option->get_type_size() == 0) return "";  // a flag
  std::string type = option->get_type_name();   // "TEXT:{full,half}": what the check says is enough
  if (const auto colon = type.rfind(':'); colon != std::string::npos) type.erase(0, colon + 1);
  for (char& c : type) c = c == ',' ? '|' : c;
  std::erase_if(type, [](char c) { return c == '{' || c == '}'; });
  std::string text = type.find_first_not_of(' ') == std::string::npos ? "" : " " + type;
  if (!option->get_default_str().empty()) text += " (" + option->get_default_str() + ")";
  if (option->get_required() && !option->get_positional()) text += " (required)";
  return text;
}

void require_distinct_files(const std::vector<std::string>& inputs,
                            const std::vector<std::string>& outputs) {
  for (auto out = outputs.begin(); out != outputs.end(); ++out) {
    if (*out == "-") throw WrongUsage("- is no file to write; standard output is /dev/stdout");
    for (const std::string& in : inputs)
      if (same_file(*out, in)) throw WrongUsage(*out + " is both read and written");
    for (auto other = outputs.begin(); other != out; ++other)
      if (same_file(*out, *other)) throw WrongUsage(*out + " is named twice");
  }
}

std::ostream& beside(const std::vector<std::string>& outputs) {
  const bool taken = std::find(outputs.begin(), outputs.end(), "/dev/stdout") != outputs.end();
  return taken ? std::cerr : std::cout;
}

void catch_interrupts() {
  // Without SA_RESTART: what waits for the reader of a pipe is not to wait on.
  struct sigaction noted = {}, before = {};
  noted.sa_handler = note_signal;
  constexpr int kSignals[] = {SIGINT, SIGTERM, SIGHUP};
  for (const int signal : kSignals) ::sigaddset(&noted.sa_mask, signal);
  for (const int signal : kSignals) {
    ::sigaction(signal, &noted, &before);
    if (before.sa_handler == SIG_IGN) ::sigaction(signal, &before, nullptr);  // nohup
  }
  // A reader that went away, or a file that may grow no more, is then a fault of writing.
  for (const int signal : {SIGPIPE, SIGXFSZ}) std::signal(signal, SIG_IGN);
}

int interrupt() noexcept { return caught_signal; }

void require_no_interrupt() {
  if (interrupt() != 0) throw Interrupted();
}

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
