// SPDX-License-Identifier: MIT
#include "handyar/io/quiet_standard_error.hpp"

#include <fcntl.h>
#include <unistd.h>

namespace handyar::io {

QuietStandardError::QuietStandardError() : saved_(::dup(STDERR_FILENO)) {
  const int null = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (saved_ >= 0 && null >= 0) ::dup2(null, STDERR_FILENO);
  if (null >= 0) ::close(null);
}

QuietStandardError::~QuietStandardError() {
  if (saved_ < 0) return;
  ::dup2(saved_, STDERR_FILENO);
  ::close(saved_);
}

}  // namespace handyar::io
