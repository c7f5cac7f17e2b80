// SPDX-License-Identifier: MIT
#include "output_folder.hpp"

#include <filesystem>

#include "handyar/io/error.hpp"
#include "handyar/io/pending_file.hpp"

namespace fs = std::filesystem;

namespace handyar::cli {

OutputFolder::OutputFolder(const std::string& path, std::initializer_list<const char*> results)
    : path_(path) {
  std::error_code fault;
  made_ = fs::create_directories(path_, fault);
  if (fault) throw io::Error(path_, "cannot be made: " + fault.message());
  for (const char* const name : results) io::require_writable(file(name));
}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  if (made_) fs::remove(path_, ignored);  // only an empty one can be
}

std::string OutputFolder::file(const std::string& name) const {
  return (fs::path(path_) / name).string();
}

}  // namespace handyar::cli
