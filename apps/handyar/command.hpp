// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <stdexcept>
#include <string>
#include <vector>

namespace handyar::cli {

inline constexpr int kDone = 0;
inline constexpr int kFailed = 1;
inline constexpr int kWrongUsage = 2;

/// A subcommand: its options are added to the application when it is made, `run` is called when the
/// user asked for it and gives the exit code.
struct Command {
  CLI::App* options;
  std::function<int()> run;
};

// One line here and one in main.cpp for each subcommand; each has its own file.
Command add_demo(CLI::App& app);
Command add_track(CLI::App& app);
Command add_inspect(CLI::App& app);
Command add_calibrate(CLI::App& app);
Command add_board(CLI::App& app);
Command add_cameras(CLI::App& app);
Command add_evaluate(CLI::App& app);
Command add_setup(CLI::App& app);
Command add_world(CLI::App& app);

/// What an option's number may be; unlike CLI11's own check it does not take nan.
CLI::Validator between(double low, double high);

/// What a file's name may end in, in capitals or not.
CLI::Validator ends_in(std::vector<std::string> extensions);

/// An option's line in the help: "--model-mm 1 to 10000 (90)", "--processing full|half (full)".
class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_option_opts(const CLI::Option* option) const override;
};

/// Two options that contradict each other and the like: exit code 2.
struct WrongUsage : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Throws WrongUsage when a file would be written that is also read, or by two options, or is
/// called "-", by which people mean standard output; empty names are none.
void require_distinct_files(const std::vector<std::string>& inputs,
                            const std::vector<std::string>& outputs);

/// Where a run says what became of it: standard output, or standard error where one of the outputs
/// is /dev/stdout.
std::ostream& beside(const std::vector<std::string>& outputs);

/// Notes SIGINT, SIGTERM and SIGHUP so that loops can end and finish their files; one that comes
/// a second later or more kills.
void catch_interrupts();
/// The signal that came, or 0.
int interrupt() noexcept;

/// What long work throws that is of no use half done: nothing of it is kept.
struct Interrupted : std::exception {};
void require_no_interrupt();

/// Seconds of a clock that never goes back.
double steady_now_s();

/// How far long work is: a line on standard error that is written over and gone at the end; nothing
/// where that is no terminal.
class ProgressLine {
 public:
  explicit ProgressLine(std::string before = "") : before_(std::move(before)) {}
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// `before`, "12 of 300", `after`; `of` 0: unknown. Ten times a second at most.
  void show(std::int64_t done, std::int64_t of, const std::string& after = "");

 private:
  std::string before_;
  bool shown_ = false;
  double next_s_ = 0;
};

}  // namespace handyar::cli
