// SPDX-License-Identifier: MIT
#include "handyar/io/pending_file.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>
#include <utility>

#include "handyar/io/error.hpp"

namespace fs = std::filesystem;

namespace handyar::io {
namespace {

constexpr std::uintmax_t kMaxTextBytes = 1u << 20;
constexpr std::size_t kMaxStemBytes = 200;  // a name may have 255, the temporary one is longer

std::string reason() { return errno != 0 ? std::strerror(errno) : "unknown reason"; }

// The file behind symbolic links, also when it does not exist yet.
fs::path behind_links(fs::path path) {
  std::error_code fault;
  for (int links = 0; links < 40 && fs::is_symlink(path, fault) && !fs::exists(path, fault);
       ++links) {
    path = path.parent_path() / fs::read_symlink(path, fault);
  }
  const fs::path canonical = fs::weakly_canonical(path, fault);
  return fault || canonical.empty() ? path : canonical;
}

}  // namespace

PendingFile::PendingFile(const std::string& target) : target_(target) {
  std::error_code ignored;
  if (target.empty()) throw Error("output file", "its name is empty");
  if (fs::is_directory(target, ignored)) throw Error(target, "is a folder, not a file");

  // Behind a symbolic link the file itself is replaced, not the link.
  const fs::path destination = behind_links(target);
  destination_ = destination.string();
  pending_ = !fs::exists(destination, ignored) || fs::is_regular_file(destination, ignored);
  if (pending_) {
    const fs::path name = destination.stem().string().substr(0, kMaxStemBytes) + ".partial-" +
                          std::to_string(::getpid()) + destination.extension().string();
    path_ = (destination.parent_path() / name).string();
  } else {
    path_ = destination_;
  }
  errno = 0;
  if (!std::ofstream(path_, std::ios::binary)) {
    pending_ = false;
    throw Error(target, "cannot be written: " + reason());
  }
}

PendingFile::PendingFile(PendingFile&& other) noexcept
    : target_(std::move(other.target_)),
      destination_(std::move(other.destination_)),
      path_(std::move(other.path_)),
      pending_(std::exchange(other.pending_, false)) {}

PendingFile::~PendingFile() {
  std::error_code ignored;
  if (pending_) fs::remove(path_, ignored);
}

void PendingFile::commit() {
  if (!pending_) return;
  std::error_code fault;
  fs::rename(path_, destination_, fault);
  if (fault) throw Error(target_, "cannot be written: " + fault.message());
  pending_ = false;
}

void require_writable(const std::string& target) { const PendingFile probe(target); }

void write_text(const std::string& target, const std::string& text) {
  PendingFile file(target);
  errno = 0;
  std::ofstream stream(file.path(), std::ios::binary);
  stream << text;
  stream.close();
  if (!stream) throw Error(target, "cannot be written: " + reason());
  file.commit();
}

std::string read_text(const std::string& path) {
  std::error_code fault;
  if (fs::is_directory(path, fault)) throw Error(path, "is a folder, not a file");
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw Error(path, "cannot be read: " + reason());
  std::string text;
  for (char block[4096]; stream.read(block, sizeof block) || stream.gcount() > 0;) {
    text.append(block, static_cast<std::size_t>(stream.gcount()));
    if (text.size() > kMaxTextBytes) throw Error(path, "is larger than 1 MiB: not such a file");
  }
  return text;
}

}  // namespace handyar::io
