// SPDX-License-Identifier: MIT
#include "driver_calls.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>

namespace handyar::io {
namespace {

// A signal is no answer.
int retried(auto call) {
  int result = -1;
  do result = call();
  while (result < 0 && errno == EINTR);
  return result;
}

}  // namespace

int DriverCalls::open(const char* path) {
  return retried([=] { return ::open(path, O_RDWR | O_NONBLOCK | O_CLOEXEC); });
}

int DriverCalls::control(int device, unsigned long request, void* argument) {
  return retried([=] { return ::ioctl(device, request, argument); });
}

void* DriverCalls::map(int device, std::size_t bytes, std::int64_t offset) {
  void* const at = ::mmap(nullptr, bytes, PROT_READ, MAP_SHARED, device, offset);
  return at == MAP_FAILED ? nullptr : at;
}

void DriverCalls::unmap(void* at, std::size_t bytes) { ::munmap(at, bytes); }

int DriverCalls::poll(int device, int timeout_ms) {
  return retried([=] {
    pollfd file{device, POLLIN, 0};
    return ::poll(&file, 1, timeout_ms);
  });
}

void DriverCalls::close(int device) { ::close(device); }

DriverCalls& system_calls() {
  static DriverCalls calls;
  return calls;
}

}  // namespace handyar::io
