// SPDX-License-Identifier: MIT
#include "handyar/io/pending_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
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

// Whether the name stands for a file that a process has open, as /dev/stdout does: what is in it is
// not ours to replace, though it may be a regular file.
bool is_open_file(fs::path path) {
  std::error_code fault;
  for (int links = 0; links < 40 && fs::is_symlink(path, fault); ++links) {
    const fs::path folder = fs::weakly_canonical(fs::absolute(path).parent_path(), fault);
    if (folder.string().starts_with("/proc/")) return true;
    path = folder / fs::read_symlink(path, fault);
  }
  return false;
}

// Beside `destination`: what it is called until it is complete.
std::string partial_prefix(const fs::path& destination) {
  return destination.stem().string().substr(0, kMaxStemBytes) + ".partial-";
}

// A run that was killed could not remove its partial file, but no longer holds its lock.
void remove_leftovers(const fs::path& destination) {
  const std::string prefix = partial_prefix(destination);
  const std::string extension = destination.extension().string();
  const fs::path folder = destination.parent_path().empty() ? "." : destination.parent_path();
  std::error_code fault;
  for (const auto& entry : fs::directory_iterator(folder, fault)) {
    const std::string name = entry.path().filename().string();
    if (name.size() <= prefix.size() + extension.size() || !name.starts_with(prefix) ||
        !name.ends_with(extension))
      continue;
    const std::string_view number = std::string_view(name).substr(
        prefix.size(), name.size() - prefix.size() - extension.size());
    if (number.find_first_not_of("0123456789") != std::string_view::npos) continue;
    const int file = ::open(entry.path().c_str(), O_RDONLY | O_NONBLOCK | O_NOFOLLOW | O_CLOEXEC);
    if (file < 0) continue;
    if (::flock(file, LOCK_EX | LOCK_NB) == 0) ::unlink(entry.path().c_str());
    ::close(file);
  }
}

}  // namespace

PendingFile::PendingFile(const std::string& target) : target_(target) {
  std::error_code ignored;
  if (target.empty()) throw Error("output file", "its name is empty");
  if (fs::is_directory(target, ignored)) throw Error(target, "is a folder, not a file");

  // Behind a symbolic link the file itself is replaced, not the link.
  const fs::path destination = behind_links(target);
  destination_ = destination.string();
  pending_ = !is_open_file(target) &&
             (!fs::exists(destination, ignored) || fs::is_regular_file(destination, ignored));
  if (!pending_) {
    path_ = target;
    // A pipe is not opened to try it: that waits for a reader, and to close it sends him away.
    if (::access(path_.c_str(), W_OK) != 0) throw Error(target, "cannot be written: " + reason());
    return;
  }
  // The file is replaced, which needs no leave to write it: but who took that away meant it.
  if (fs::exists(destination, ignored) && ::access(destination_.c_str(), W_OK) != 0)
    throw Error(target, "cannot be written: " + reason());
  remove_leftovers(destination);
  const fs::path name =
      partial_prefix(destination) + std::to_string(::getpid()) + destination.extension().string();
  path_ = (destination.parent_path() / name).string();
  errno = 0;
  if (!std::ofstream(path_, std::ios::binary))
    throw Error(target, "cannot be written: " + reason());
  // What was private stays so; it is opened by its name again, so its owner must be able to write.
  if (const fs::file_status before = fs::status(destination, ignored); fs::exists(before))
    fs::permissions(path_, before.permissions() | fs::perms::owner_read | fs::perms::owner_write,
                    ignored);
  lock_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
  if (lock_ >= 0) ::flock(lock_, LOCK_EX | LOCK_NB);
}

PendingFile::PendingFile(PendingFile&& other) noexcept
    : target_(std::move(other.target_)),
      destination_(std::move(other.destination_)),
      path_(std::move(other.path_)),
      pending_(std::exchange(other.pending_, false)),
      lock_(std::exchange(other.lock_, -1)) {}

PendingFile::~PendingFile() {
  std::error_code ignored;
  if (pending_) fs::remove(path_, ignored);
  if (lock_ >= 0) ::close(lock_);
}

std::ofstream PendingFile::stream() const {
  errno = 0;
  // Appended, since what is written directly may be a file that has something in it.
  std::ofstream stream(path_, std::ios::binary | std::ios::app);
  if (!stream && errno == EINTR) throw Interrupted(target_, "nobody reads it, and a signal came");
  if (!stream) throw Error(target_, "cannot be written: " + reason());
  return stream;
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
  std::ofstream stream = file.stream();
  errno = 0;
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
