// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace handyar::cli {

/// A folder for results: made where there is none, gone again when nothing came into it.
class OutputFolder {
 public:
  /// Throws io::Error when files cannot be written to it.
  explicit OutputFolder(const std::string& path);
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
