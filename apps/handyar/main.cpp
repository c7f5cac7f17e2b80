// SPDX-License-Identifier: MIT
#include <fcntl.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <iostream>

#include "command.hpp"
#include "handyar/api.h"
#include "handyar/io/error.hpp"
#include "handyar/io/frame_source.hpp"

namespace {

namespace fs = std::filesystem;
using namespace handyar::cli;

constexpr const char* kExamples =
    "Examples:\n"
    "  handyar demo                                    see it work\n"
    "  handyar track 0 --show                          your own hand in front of the first camera\n"
    "  handyar track hand.mp4 --poses poses.csv --video annotated.mp4\n"
    "\nExit codes: 0 done, 1 failed (one line says why), 2 wrong usage, 128 + n ended by signal n.";

int wrong_usage(const CLI::App& app, const std::string& fault) {
  std::string program = "handyar";
  for (const CLI::App* command : app.get_subcommands()) program += " " + command->get_name();
  std::cerr << "handyar: " << fault << " (" << program << " --help tells more)\n";
  return kWrongUsage;
}

// The shell makes many names of *.png. CLI11 takes a mistyped subcommand for a missing one.
std::string fault_of(const CLI::App& app, const CLI::ParseError& e, int argc, char** argv) {
  const std::vector<std::string> extras = app.remaining(true);
  if (!extras.empty())
    if (const std::string hint = handyar::io::pattern_hint(extras[0]); !hint.empty())
      return "INPUT is one name: " + hint;
  if (!app.get_subcommands().empty() || argc < 2) return e.what();
  return (argv[1][0] == '-' ? "there is no option " : "there is no subcommand ") +
         std::string(argv[1]);
}

// A script's empty variable is not an option that was left out.
void require_values(const CLI::App& app) {
  for (const CLI::App* command : app.get_subcommands())
    for (const CLI::Option* option : command->get_options())
      for (const std::string& value : option->results())
        if (value.empty()) throw WrongUsage(option->get_name() + " is empty");
}

// Who starts a program may have closed its standard streams: the first file that it opens would
// then get what is meant for them.
void open_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (::fcntl(stream, F_GETFD) < 0) ::open("/dev/null", O_RDWR);
}

void require_standard_output() {
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
    throw handyar::io::Error("standard output", "cannot be written");
}

int tell_interrupted() {
  std::cerr << "handyar: interrupted, nothing was written\n";
  return 128 + interrupt();
}

int run(int argc, char** argv) {
  CLI::App app{"A bare outstretched hand, used like a printed AR marker.", "handyar"};
  app.set_version_flag("--version", "handyar " HANDYAR_VERSION);
  app.require_subcommand(1);
  app.formatter(std::make_shared<HelpFormatter>());  // the subcommands take it from here
  app.footer(kExamples);
  const Command commands[] = {
      add_demo(app),  add_track(app),   add_inspect(app),  add_world(app), add_calibrate(app),
      add_board(app), add_cameras(app), add_evaluate(app), add_setup(app),
  };
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {  // --help, --version
    if (app.get_subcommands().empty() && argv[1][0] != '-')
      return wrong_usage(app, std::string("there is no subcommand ") + argv[1]);
    return app.exit(asked);
  } catch (const CLI::ParseError& e) {
    return wrong_usage(app, fault_of(app, e, argc, argv));
  }
  try {
    require_values(app);
    for (const Command& command : commands) {
      if (command.options->parsed()) return command.run();
    }
  } catch (const WrongUsage& e) {
    return wrong_usage(app, e.what());
  }
  return kWrongUsage;
}

}  // namespace

int main(int argc, char** argv) {
  open_standard_streams();
  try {
    const int code = run(argc, argv);
    if (code == kDone) require_standard_output();
    return code;
  } catch (const Interrupted&) {
    return tell_interrupted();
  } catch (const handyar::io::Interrupted&) {
    return tell_interrupted();
  } catch (const handyar::io::Error& e) {
    std::cerr << "handyar: " << e.what() << '\n';
  } catch (const fs::filesystem_error& e) {
    std::cerr << "handyar: " << e.path1().string() << ": " << e.code().message() << '\n';
  } catch (const std::bad_alloc&) {
    std::cerr << "handyar: out of memory\n";
  } catch (const std::exception& e) {
    std::cerr << "handyar: internal error: " << e.what() << '\n';
  }
  return kFailed;
}
