// SPDX-License-Identifier: MIT
#include "handyar/io/sample.hpp"

#include <filesystem>

#include "handyar/io/error.hpp"

namespace fs = std::filesystem;

namespace handyar::io {

std::string data_file(const std::string& name) {
  std::error_code fault;
  const fs::path program = fs::read_symlink("/proc/self/exe", fault);
  const fs::path folders[] = {program.parent_path() / HANDYAR_DATA_FROM_BIN,
                              HANDYAR_INSTALL_DATA_DIR, HANDYAR_SOURCE_DATA_DIR};
  for (const fs::path& folder : folders) {
    const fs::path file = (folder / name).lexically_normal();
    if (fs::exists(file, fault)) return file.string();
  }
  throw Error(name, "this sample is not installed with the program");
}

}  // namespace handyar::io
