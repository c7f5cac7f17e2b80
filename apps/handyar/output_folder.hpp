// SPDX-License-Identifier: MIT
#pragma once

#include <initializer_list>
#include <string>

namespace handyar::cli {

/// A folder for results: made where there is none, gone again when nothing came into it.
class OutputFolder {
 public:
  /// Throws io::Error when one of the files that will come into it could not be written.
  OutputFolder(const std::string& path, std::initializer_list<const char*> results);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// The path of a file in it.
  std::string file(const std::string& name) const;

 private:
  std::string path_;
  bool made_;
};

}  // namespace handyar::cli
