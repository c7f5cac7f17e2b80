// SPDX-License-Identifier: MIT
#include "handyar/io/quiet_standard_error.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <mutex>

namespace handyar::io {
namespace {

// Standard error is the process's, not a thread's: the first one that lives turns it away, and the
// last one gives it back.
std::mutex mutex;
int alive = 0, saved = -1;

}  // namespace

QuietStandardError::QuietStandardError() {
  const std::lock_guard lock(mutex);
  if (alive++ > 0) return;
  saved = ::fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 0);
  const int null = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (saved >= 0 && null >= 0) ::dup2(null, STDERR_FILENO);
  if (null >= 0) ::close(null);
}

QuietStandardError::~QuietStandardError() {
  const std::lock_guard lock(mutex);
  if (--alive > 0 || saved < 0) return;
  ::dup2(saved, STDERR_FILENO);
  ::close(saved);
  saved = -1;
}

}  // namespace handyar::io
