// SPDX-License-Identifier: MIT
#include "handyar/io/cameras.hpp"

#include <algorithm>
#include <iomanip>
#include <iostream>

#include "command.hpp"

namespace handyar::cli {
namespace {

int print_cameras() {
  const std::vector<io::CameraInfo> cameras = io::list_cameras();
  if (cameras.empty()) {
    std::cout << "no camera found\n";
    return kDone;
  }
  std::size_t width = 4;
  for (const io::CameraInfo& camera : cameras) width = std::max(width, camera.name.size());
  const int name_width = static_cast<int>(width) + 2;
  std::cout << std::left << std::setw(14) << "camera" << std::setw(name_width) << "name"
            << "sizes\n";
  for (const io::CameraInfo& camera : cameras) {
    std::cout << std::setw(14) << camera.path << std::setw(name_width) << camera.name;
    if (!camera.fault.empty()) std::cout << "cannot be opened: " << camera.fault;
    for (const auto& [w, h] : camera.sizes_px) std::cout << w << "x" << h << " ";
    std::cout << '\n';
  }
  return kDone;
}

}  // namespace

Command add_cameras(CLI::App& app) {
  CLI::App* options = app.add_subcommand("cameras", "List the cameras of this machine");
  options->footer("Each by its path, its name or its number: handyar track 0 --show");
  return {options, print_cameras};
}

}  // namespace handyar::cli
