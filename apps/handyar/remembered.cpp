// SPDX-License-Identifier: MIT
#include "remembered.hpp"

#include <cstdlib>
#include <filesystem>

#include "command.hpp"
#include "handyar/io/camera_file.hpp"
#include "handyar/io/error.hpp"
#include "handyar/io/hand_file.hpp"
#include "handyar/io/pending_file.hpp"

namespace fs = std::filesystem;

namespace handyar::cli {
namespace {

constexpr const char *kInput = "input", *kCamera = "camera.yml", *kHand = "hand.json";

// As the XDG base directory specification has it: a relative path counts as none.
fs::path base_folder() {
  if (const char* config = std::getenv("XDG_CONFIG_HOME"); config && *config == '/') return config;
  if (const char* home = std::getenv("HOME"); home && *home == '/')
    return fs::path(home) / ".config";
  return {};
}

std::string in_folder(const char* name) { return (fs::path(config_folder()) / name).string(); }

std::string made_in_folder(const char* name) {
  std::error_code fault;
  fs::create_directories(config_folder(), fault);
  if (fault) throw io::Error(config_folder(), "cannot be made: " + fault.message());
  return in_folder(name);
}

std::string if_there(const char* name) {
  std::error_code ignored;
  const std::string file = in_folder(name);
  return fs::exists(file, ignored) ? file : "";
}

}  // namespace

std::string config_folder() {
  const fs::path base = base_folder();
  if (base.empty()) throw io::Error("HOME", "is not set: there is no folder to remember things in");
  return (base / "handyar").string();
}

Remembered remembered() {
  if (base_folder().empty()) return {};
  Remembered r{"", if_there(kCamera), if_there(kHand)};
  if (const std::string file = if_there(kInput); !file.empty()) {
    r.input = io::read_text(file);
    r.input.erase(std::min(r.input.find('\n'), r.input.size()));
  }
  return r;
}

std::string input_of(const std::string& given) {
  const std::string input = given.empty() ? remembered().input : given;
  if (input.empty()) throw WrongUsage("INPUT is required, handyar setup remembers one");
  return input;
}

void remember_input(const std::string& input) {
  io::write_text(made_in_folder(kInput), input + "\n");
}
void remember_camera(const Camera& camera) { io::write_camera(made_in_folder(kCamera), camera); }
void remember_hand(const HandModel& hand) { io::write_hand(made_in_folder(kHand), hand); }
void forget(bool hand_too) {
  std::error_code ignored;
  for (const char* const name : {kInput, kCamera}) fs::remove(in_folder(name), ignored);
  if (hand_too) fs::remove(in_folder(kHand), ignored);
  fs::remove(config_folder(), ignored);
}

}  // namespace handyar::cli
