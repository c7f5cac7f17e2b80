// SPDX-License-Identifier: MIT
#pragma once

#include <fstream>
#include <string>

namespace handyar::io {

/// A file in the making: it is written under a temporary name beside its target and takes the
/// target's place on commit(). Without commit() nothing is left and an older file stays as it was.
/// What a killed run left of the same target is removed.
/// A target that is not a regular file (a pipe) is written directly, and so is one that is open
/// already (/dev/stdout), behind what is in it.
class PendingFile {
 public:
  /// Creates the temporary file; throws Error when that is impossible.
  explicit PendingFile(const std::string& target);
  ~PendingFile();
  PendingFile(PendingFile&& other) noexcept;
  PendingFile& operator=(PendingFile&&) = delete;

  /// Where to write; has the target's extension.
  const std::string& path() const noexcept { return path_; }
  const std::string& target() const noexcept { return target_; }
  /// What writes there; throws Error.
  std::ofstream stream() const;

  void commit();

 private:
  std::string target_, destination_, path_;
  bool pending_ = false;
  int lock_ = -1;  // of the temporary file: tells it from what a killed run left
};

/// Throws Error when a PendingFile could not be made: for results of long work, before it is done.
void require_writable(const std::string& target);

/// Writes a whole text file that way.
void write_text(const std::string& target, const std::string& text);

/// Reads a whole text file of at most 1 MiB; throws Error.
std::string read_text(const std::string& path);

}  // namespace handyar::io
